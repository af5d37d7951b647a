#include <gtest/gtest.h>

#include <limits>

#include <lcmslam/cloud/cloud_filter.hpp>

namespace lcmslam {
namespace {

TEST(CloudFilter, KeepsWhatIsWithinTheLimits) {
  ColouredCloud cloud;
  const auto add = [&](const Eigen::Vector3f& p, const Eigen::Vector3f& n, float sigma) {
    cloud.points.push_back(p);
    cloud.normals.push_back(n);
    cloud.sigmas.push_back(sigma);
    cloud.colours.emplace_back(0, 0, 0);
  };
  const Eigen::Vector3f facing(0, 0, -1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  add({0, 0, 2}, facing, 0.01f);     // good
  add({0, 0, 0.1f}, facing, 0.01f);  // too near
  add({0, 0, 20}, facing, 0.01f);    // too far
  add({0, 0, 2}, {1, 0, 0}, 0.01f);  // grazing
  add({0, 0, 2}, facing, 1.0f);      // too noisy
  add({nan, 0, 2}, facing, 0.01f);
  add({0, 0, 2}, {nan, nan, nan}, 0.01f);
  EXPECT_EQ(usable_points(cloud).size(), 1u);
}

}  // namespace
}  // namespace lcmslam
