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

// A lidar's, say: they come without.
TEST(CloudFilter, WithoutNormalsKeepsAllWhereNoneAreAskedFor) {
  const Cloud cloud({{0, 0, 2}, {0, 0, 20}, {0.5f, 0, 3}});
  ColouredCloud coloured;
  coloured.points = cloud.points;
  coloured.colours.resize(3);
  EXPECT_EQ(usable_points(cloud).size(), 0U);
  EXPECT_EQ(usable_points(coloured).size(), 0U);
  CloudFilterSettings settings;
  settings.normals = false;
  const Cloud usable = usable_points(cloud, settings);
  EXPECT_EQ(usable.points, (std::vector<Eigen::Vector3f>{{0, 0, 2}, {0.5f, 0, 3}}));  // one is too far
  EXPECT_FALSE(usable.has_normals());
  EXPECT_EQ(usable_points(coloured, settings).points, usable.points);
}

}  // namespace
}  // namespace lcmslam
