#include <lcmslam/calibration/self/sighting_comparison.hpp>

#include <gtest/gtest.h>
#include <cmath>

#include <lcmslam/calibration/self/depth_patch.hpp>
#include "tests/unit/calibration_self/box_scene.hpp"

namespace lcmslam {
namespace {

// A wide patch of a slanted wall sees much of a wiggle's period.
TEST(SightingComparison, PatchesAreFreedOfWhatRangesErrBy) {
  RgbdCalibration truth = testing::true_head();
  truth.depth_clock_offset = truth.rolling_shutter = 0;
  truth.depth_noise = {0.005, 0, 0, 0};
  truth.depth_max = 7.5;
  RgbdCalibration start = truth;
  truth.depth_error.wiggle = 0.006, truth.depth_error.period = 1.9, truth.depth_error.phase = 1;
  std::vector<testing::Shot> shots;
  for (const double turn : {0.5, 0.6, 0.7, 0.8}) shots.push_back(testing::shot({0, 0, turn}, {0, turn, 0}));
  SceneObservations scene = testing::seen_room(truth, shots, 300);
  HeadModel model(start);
  BundleState state(model, scene);
  const double piece = state.curve.range_of(2) - state.curve.range_of(1);
  const double smoothed =
      (2 + std::cos(2 * M_PI * piece / truth.depth_error.period)) / 3;  // a sine by the spline
  for (std::size_t i = 0; i < state.curve.values.size(); ++i)
    state.curve.values[i] = -truth.depth_error.at(state.curve.range_of(static_cast<int>(i))) / smoothed;

  double squares = 0;
  int count = 0;
  for (const Comparison& c : compare(state, {}, nullptr).all) {
    if (!c.patch) continue;
    const Eigen::Isometry3d T = shots[c.keyframe].T_world_camera * truth.T_colour_depth;
    const Eigen::Vector3d ray = truth.depth.ray({c.patch->u, c.patch->v});
    const double off = 1 / c.patch->inverse - testing::range_to_wall(T.translation(), T.linear() * ray);
    squares += off * off, ++count;
    EXPECT_NEAR(c.patch->freed, state.curve.at(c.range), 1e-9);
  }
  ASSERT_GT(count, 100);
  EXPECT_LT(1e3 * std::sqrt(squares / count), 0.3) << "mm";
}

// Where noise has tilted a patch by chance, those of the other views say how the wall lies.
TEST(SightingComparison, SlopesAreThoseOfTheOtherViews) {
  RgbdCalibration truth = testing::true_head();
  truth.depth_noise = {0.02, 0, 0, 0};
  const std::vector<testing::Shot> shots = testing::rich_motion();
  SceneObservations scene = testing::seen_room(truth, shots, 300);
  testing::add_shared_noise(scene, 0.03, 8);
  HeadModel model(truth);
  const BundleState state(model, scene);
  const double seconds = 0.018 + truth.depth_clock_offset;
  double own = 0, shared = 0;
  int count = 0;
  for (const Comparison& c : compare(state, {}, nullptr).all) {
    if (!c.patch) continue;
    const Eigen::Vector2d at(c.patch->u, c.patch->v);
    const auto alone =
        depth_patch(scene.keyframes[c.keyframe].inverse_depth, at, truth.depth, truth.depth_noise);
    ASSERT_TRUE(alone);
    const Vector6d& twist = shots[c.keyframe].twist;
    const double t = seconds + c.row * truth.rolling_shutter;
    Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
    moved.linear() = so3_exp(t * twist.tail<3>());
    moved.translation() = moved.linear() * (t * twist.head<3>());
    const Eigen::Isometry3d T = shots[c.keyframe].T_world_camera * moved * truth.T_colour_depth;
    const auto inverse = [&](double du, double dv) {
      return 1 / testing::range_to_wall(T.translation(),
                                        T.linear() * truth.depth.ray(at + Eigen::Vector2d(du, dv)));
    };
    if (c.patch->along_u == alone->along_u) continue;  // too few views agree
    const Eigen::Vector2d wall((inverse(2, 0) - inverse(-2, 0)) / 4, (inverse(0, 2) - inverse(0, -2)) / 4);
    if ((wall - Eigen::Vector2d(alone->along_u, alone->along_v)).norm() > 4e-4) continue;  // at a corner
    own += (wall - Eigen::Vector2d(alone->along_u, alone->along_v)).squaredNorm();
    shared += (wall - Eigen::Vector2d(c.patch->along_u, c.patch->along_v)).squaredNorm();
    EXPECT_EQ(c.patch->inverse, alone->inverse) << "depths stay";
    ++count;
  }
  ASSERT_GT(count, 500);
  EXPECT_LT(std::sqrt(shared), 0.7 * std::sqrt(own));
}

}  // namespace
}  // namespace lcmslam
