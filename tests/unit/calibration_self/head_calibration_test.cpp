// Where the second round begins.

#include <lcmslam/calibration/self/head_calibration.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

// By the rays of a head that is a degree off it would begin many pixels off, and take a part of a drive for
// something else.
TEST(HeadCalibration, GoesOnWhereKeyframesAndRaysWereFound) {
  RgbdCalibration head;
  head.colour.width = 640, head.colour.height = 480;
  head.colour.fx = head.colour.fy = 500, head.colour.cx = 320, head.colour.cy = 240;
  SceneObservations scene;
  scene.keyframes.resize(2);
  scene.keyframes[1].T_world_camera.translation() = Eigen::Vector3d(1, 0, -0.5);
  scene.landmarks.push_back({{0.3, 0.1, 2}, {{0, {10, 10}, 1}, {1, {570, 140}, 1}, {0, {5, 5}, 1}}});
  SceneObservations adjusted = scene;
  adjusted.keyframes[1].T_world_camera =
      Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::Isometry3d(so3_exp({0, 0.2, 0}));

  continue_at(adjusted, head, scene);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_TRUE(scene.keyframes[k].T_world_camera.isApprox(adjusted.keyframes[k].T_world_camera)) << k;
  const Eigen::Vector3d seen = adjusted.keyframes[1].T_world_camera.inverse() * scene.landmarks[0].point;
  EXPECT_TRUE(seen.isApprox(2.5 * Eigen::Vector3d(0.5, -0.2, 1))) << seen.transpose();
}

}  // namespace
}  // namespace lcmslam
