// The second round begins where the first one ended.

#include <lcmslam/calibration/self/head_calibration.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, double metres) {
  return Eigen::Translation3d(metres, -metres, 2 * metres) * T;
}

// Looked up by its first look alone, with a head that is a degree off, a landmark is pixels off, and a part
// of a drive may be taken for something else.
TEST(HeadCalibration, GoesOnWhereKeyframesAndLandmarksWereFound) {
  SceneObservations scene;
  for (int k = 0; k < 3; ++k)
    scene.keyframes.emplace_back().T_world_camera = moved(Eigen::Isometry3d::Identity(), k);
  for (int i = 0; i < 2; ++i)
    scene.landmarks.push_back(
        {Eigen::Vector3d(i, 1, 2), {{0, {10, 10}, 1}, {2, {20, 10}, 1}, {1, {5, 5}, 1}}});
  SceneObservations adjusted = scene;
  for (ObservedKeyframe& keyframe : adjusted.keyframes)
    keyframe.T_world_camera = moved(keyframe.T_world_camera, 0.1);
  adjusted.landmarks[0].point = {7, 8, 9};
  adjusted.landmarks[0].sightings.pop_back();

  continue_at(adjusted, scene);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_TRUE(scene.keyframes[k].T_world_camera.isApprox(adjusted.keyframes[k].T_world_camera)) << k;
  EXPECT_EQ(scene.landmarks[0].point, Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(scene.landmarks[0].sightings.size(), 3U) << "all are looked at again";
  EXPECT_TRUE(scene.landmarks[1].point.isApprox(Eigen::Vector3d(1.1, 0.9, 2.2))) << "with its keyframe";
}

}  // namespace
}  // namespace lcmslam
