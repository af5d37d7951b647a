#include <lcmslam/rendering/orbit.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {
namespace {

/// A floor, 4 x 2 m around (10, 5, 1), and one point that is far away.
ColouredCloud floor_of_map() {
  ColouredCloud cloud;
  for (int i = -20; i <= 20; ++i)
    for (int j = -10; j <= 10; ++j)
      cloud.points.push_back(Eigen::Vector3d(10 + 0.1 * i, 5 + 0.1 * j, 1).cast<float>());
  cloud.points.emplace_back(500, 0, 0);
  cloud.colours.assign(cloud.size(), cv::Vec3b(1, 2, 3));
  cloud.normals.assign(cloud.size(), Eigen::Vector3f::UnitZ());
  return cloud;
}

TEST(Orbit, GoesOnceAroundAndLooksAtTheMiddle) {
  const ColouredCloud cloud = floor_of_map();
  PictureRequest request;
  request.view = MapView::front;
  request.cloud = &cloud;
  const Eigen::Vector3d middle(10, 5, 1);
  const auto viewers = orbit(request, 8);
  ASSERT_EQ(viewers.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_TRUE(viewers[i].linear().isUnitary(1e-9));
    EXPECT_NEAR(viewers[i].linear().determinant(), 1, 1e-9);
    const Eigen::Vector3d seen = viewers[i].inverse() * middle;
    EXPECT_NEAR(seen.x(), 0, 0.05);
    EXPECT_NEAR(seen.y(), 0, 0.05);
    EXPECT_GT(seen.z(), 2);
    EXPECT_LT(viewers[i].linear()(2, 1), 0) << "the picture's down is down";
    EXPECT_GT(viewers[i].translation().z(), middle.z());
    const Eigen::Vector3d a = viewers[i].linear().col(2), b = viewers[(i + 1) % 8].linear().col(2);
    const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.x() * b.x() + a.y() * b.y());
    EXPECT_NEAR(turn, M_PI / 4, 1e-9);
  }
}

TEST(Orbit, TheWholeMapIsInThePictureFromEverywhere) {
  const ColouredCloud cloud = floor_of_map();
  PictureRequest request;
  request.view = MapView::front;
  request.cloud = &cloud;
  request.width = 300;
  request.height = 200;
  const double focal = request.width / 2.0 / std::tan(request.field_of_view / 2);
  for (const Eigen::Isometry3d& T_world_viewer : orbit(request, 12)) {
    int outside = 0;
    for (const Eigen::Vector3f& point : cloud.points) {
      const Eigen::Vector3d p = T_world_viewer.inverse() * point.cast<double>();
      outside += p.z() <= 0 || std::abs(focal * p.x() / p.z()) > 150 || std::abs(focal * p.y() / p.z()) > 100;
    }
    EXPECT_LE(outside, static_cast<int>(cloud.size() / 20));
  }
}

}  // namespace
}  // namespace lcmslam
