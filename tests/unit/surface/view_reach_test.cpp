#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/surface/block_update.hpp>
#include <lcmslam/surface/view_reach.hpp>
#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

CameraModel bent_camera() {
  return {160, 120, 140, 150, 76.2, 61.7, {-0.25, 0.08, 0.002, -0.001, -0.01}};
}

/// A wall in the left half, free space beyond what is measured in the right one.
SurfaceView view_of_half_a_wall() {
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = bent_camera();
  calibration.depth_noise = {0.002, 0, 0, 0};
  RgbdFrame frame;
  frame.depth =
      testing_scene::render({{{{0.5, 0, 1}, 1.2}}, {}}, calibration.depth, Eigen::Isometry3d::Identity());
  frame.depth.colRange(80, 160).setTo(0);
  frame.colour = cv::Mat(frame.depth.size(), CV_8UC3, cv::Scalar(20, 60, 200));
  const SurfaceViewMaker maker(calibration, SurfaceSettings());
  return maker.view(maker.image(frame));
}

TEST(ViewReach, HoldsEveryBlockThatChanges) {
  const SurfaceView view = view_of_half_a_wall();
  Random random(4);
  LookSettings settings;
  settings.most_weight = 1000;
  int changed = 0, held = 0;
  for (int i = 0; i < 20000; ++i) {
    const VoxelBlocks blocks(i % 2 == 0 ? 0.01 : 0.04, 4);
    const Eigen::Matrix3f R = Eigen::AngleAxisf(static_cast<float>(random.uniform(0, 3)),
                                                Eigen::Vector3f(0.3f, 0.5f, 1).normalized())
                                  .toRotationMatrix();
    const Eigen::Vector3f centre(static_cast<float>(random.uniform(-1.5, 1.5)),
                                 static_cast<float>(random.uniform(-1.5, 1.5)),
                                 static_cast<float>(random.uniform(-0.3, 2)));
    BlockPlace place;
    for (int axis = 0; axis < 3; ++axis) place.step[axis] = blocks.voxel_size() * R.col(axis);
    place.first = centre - 3.5f * (place.step[0] + place.step[1] + place.step[2]);
    settings.truncation = blocks.truncation();
    VoxelBlock block;
    const bool holds = ViewReach(view, R, blocks).holds(centre);
    const bool changes = update_block(view, place, settings, block);
    EXPECT_TRUE(holds || !changes) << i << ": " << centre.transpose();
    changed += changes;
    held += holds;
  }
  EXPECT_GT(changed, 1000);
  EXPECT_LT(held, 7000);
}

}  // namespace
}  // namespace lcmslam
