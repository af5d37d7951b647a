// A head is found exactly where the motion shows it, and what no motion shows is said.

#include <lcmslam/calibration/self/bundle_adjustment.hpp>

#include <gmock/gmock.h>

#include <lcmslam/calibration/self/residuals.hpp>
#include "tests/unit/calibration_self/box_scene.hpp"

namespace lcmslam {
namespace {

using namespace testing;

RgbdCalibration spoiled(RgbdCalibration c) {
  c.colour.fx *= 1.03, c.colour.fy *= 1.03;
  c.colour.cx += 4, c.colour.cy -= 3;
  c.colour.distortion = {0, 0, 0, 0};
  if (c.depth_registered)
    c.depth = c.colour;
  else {
    c.T_colour_depth.translation() += Eigen::Vector3d(0.012, -0.01, 0.012);
    c.T_colour_depth.linear() = so3_exp({0.01, -0.009, 0.01}) * c.T_colour_depth.linear();
  }
  c.depth_clock_offset = 0;
  c.rolling_shutter = 0.01;
  return c;
}

/// A sensor so sure that no patch may cross the room's edges, for what is to be found exactly.
RgbdCalibration sharp(RgbdCalibration c) {
  c.depth_noise = {2e-4, 0, 0, 0};
  return c;
}

/// Priors that do not pull: what is found is what is seen. Without wheels nothing tells the scale of all.
CalibrationPriors wide() {
  CalibrationPriors p;
  p.aspect = 0.1;
  p.depth_scale = p.depth_offset = p.third_radial = 0;
  p.radial = 10, p.tangential = 1, p.principal_point = 1000, p.focal_length = 1;
  p.translation = p.rotation = 1;
  p.depth_clock = 1, p.rolling_shutter = 0.1;
  return p;
}

TEST(SelfCalibration, ProjectsAsTheCameraModelDoes) {
  const CameraModel camera = true_head().colour;
  const HeadModel model(true_head());
  const double rational[3] = {};
  double pixel[2];
  ASSERT_TRUE(residuals::project(model.values.data(), rational, Eigen::Vector3d(0.3, -0.4, 1.1), pixel));
  EXPECT_LT((Eigen::Vector2d(pixel[0], pixel[1]) - *camera.project({0.3, -0.4, 1.1})).norm(), 1e-9);
  EXPECT_FALSE(residuals::project(model.values.data(), rational, Eigen::Vector3d(0.3, -0.4, -1.1), pixel));
}

// But for what wide patches cost: rows that are read one after the other do not see a plane as quite a plane.
TEST(SelfCalibration, FindsAHeadOfTwoCamerasExactly) {
  const RgbdCalibration truth = sharp(true_head());
  SceneObservations scene = seen_room(truth, rich_motion(), 400);
  HeadModel model(spoiled(truth));
  const BundleResult result = adjust_bundle(model, scene, wide(), {});
  const RgbdCalibration found = model.calibration();
  EXPECT_NEAR(found.colour.fx, truth.colour.fx, 0.03);
  EXPECT_NEAR(found.colour.fy, truth.colour.fy, 0.03);
  EXPECT_NEAR(found.colour.cx, truth.colour.cx, 0.03);
  EXPECT_NEAR(found.colour.cy, truth.colour.cy, 0.03);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(found.colour.distortion[i], truth.colour.distortion[i], 2e-3) << i;
  EXPECT_LT(distance_between(found.T_colour_depth, truth.T_colour_depth), 4e-4);
  EXPECT_LT(angle_between(found.T_colour_depth, truth.T_colour_depth), 1e-4);
  EXPECT_NEAR(found.depth_clock_offset, truth.depth_clock_offset, 1e-4);
  EXPECT_NEAR(found.rolling_shutter, truth.rolling_shutter, 2e-4);
  EXPECT_NEAR(model.values[head::depth_rows], truth.rolling_shutter, 1e-3);
  EXPECT_TRUE(result.unobserved_directions.empty()) << result.unobserved_directions.front();
}

// Addresses differ from run to run; the head's numbers lie before the heap here, and then behind it.
TEST(SelfCalibration, IsTheSameWhereverItsNumbersLie) {
  const RgbdCalibration truth = true_head();
  static HeadModel low(spoiled(truth));
  HeadModel high(spoiled(truth));
  for (HeadModel* model : {&low, &high}) {
    SceneObservations scene = seen_room(truth, rich_motion(), 100);
    adjust_bundle(*model, scene, wide(), {});
  }
  EXPECT_EQ(low.values, high.values);
}

TEST(SelfCalibration, FindsARegisteredHeadExactly) {
  const RgbdCalibration truth = true_head(true);
  SceneObservations scene = seen_room(truth, rich_motion(), 400);
  HeadModel model(spoiled(truth));
  const BundleResult result = adjust_bundle(model, scene, wide(), {});
  const RgbdCalibration found = model.calibration();
  EXPECT_NEAR(found.colour.fx, truth.colour.fx, 0.05);
  EXPECT_NEAR(found.colour.cx, truth.colour.cx, 0.05);
  EXPECT_NEAR(found.colour.distortion[0], truth.colour.distortion[0], 3e-3);
  EXPECT_NEAR(found.depth_clock_offset, truth.depth_clock_offset, 2e-4);
  EXPECT_EQ(found.depth.fx, found.colour.fx);
  EXPECT_TRUE(result.held(head::tx)) << "depth pixels are colour pixels";
  EXPECT_TRUE(is_observed(result, head::fx, {}));
}

// About one axis through the colour camera everything that the depth camera sees may be moved along that axis
// and turned about it: landmarks follow on their rays. (The angle is not asked for here: patches at the
// room's corners pretend to know a little of it.)
TEST(SelfCalibration, SaysWhatTurningInPlaceCannotTell) {
  std::vector<Shot> shots;
  for (int i = 0; i < 12; ++i) shots.push_back(shot({0, 0, 0}, {0, 0.12 * i - 0.7, 0}));
  RgbdCalibration truth = true_head();
  truth.T_colour_depth.linear().setIdentity();  // its y is the axis
  truth.rolling_shutter = 0;
  SceneObservations scene = seen_room(truth, shots, 300);
  HeadModel model(truth);
  CalibrationPriors priors;
  priors.depth_scale = priors.depth_offset = 0;
  const BundleResult result = adjust_bundle(model, scene, priors, {});
  EXPECT_FALSE(is_observed(result, head::ty, {})) << result.sigmas[head::ty];
  EXPECT_FALSE(is_observed(result, head::depth_clock, {})) << "nothing moves: stamps do not matter";
  EXPECT_TRUE(is_observed(result, head::fx, {})) << result.sigmas[head::fx];
  EXPECT_TRUE(is_observed(result, head::rx, {})) << result.sigmas[head::rx];
  EXPECT_THAT(result.unobserved_directions, ::testing::Contains(::testing::HasSubstr("colour_depth.y")));
  EXPECT_NEAR(model.T_colour_depth().translation().y(), truth.T_colour_depth.translation().y(), 1e-3)
      << "what is not seen stays where it was";
}

TEST(SelfCalibration, SaysThatNothingTellsTheScaleOfAll) {
  SceneObservations scene = seen_room(true_head(), rich_motion(), 300);
  HeadModel model(true_head());
  const BundleResult result = adjust_bundle(model, scene, {}, {});
  EXPECT_FALSE(is_observed(result, head::depth_scale, {})) << result.sigmas[head::depth_scale];
  EXPECT_TRUE(is_observed(result, head::tx, {}));
  model.values[head::depth_scale] = 1.01;
  EXPECT_EQ(observed_head(model, result, {}).values[head::depth_scale], 1) << "as it was at the start";
}

TEST(SelfCalibration, RefusesARecordingThatShowsNothing) {
  SceneObservations scene = seen_room(true_head(), rich_motion(), 5);
  HeadModel model(true_head());
  EXPECT_THROW(adjust_bundle(model, scene, {}, {}), std::runtime_error);
}

// Pixels with noise: what is found is off by what its sigma says.
TEST(SelfCalibration, KnowsItsErrors) {
  const RgbdCalibration truth = true_head();
  SceneObservations scene = seen_room(truth, rich_motion(), 400);
  add_noise(scene, 0.4, truth.depth_noise, 3);
  HeadModel model(spoiled(truth));
  BundleSettings settings;
  settings.correlation = 1;  // these are independent
  const BundleResult result = adjust_bundle(model, scene, wide(), settings);
  EXPECT_NEAR(result.pixel_scale, 0.4, 0.08);
  const double off = std::abs(model.values[head::fx] - truth.colour.fx);
  EXPECT_LT(off, 4 * result.sigmas[head::fx]);
  EXPECT_LT(result.sigmas[head::fx], 0.8);
  EXPECT_GT(result.sigmas[head::fx], 0.02);
}

// Small patches that noise has tilted hold the depth camera where the first look put it.
TEST(SelfCalibration, ComesNearFromFarOffThroughNoise) {
  const RgbdCalibration truth = true_head();
  SceneObservations scene = seen_room(truth, rich_motion(), 600);
  add_noise(scene, 0.05, truth.depth_noise, 4);
  HeadModel model(spoiled(truth));
  CalibrationPriors priors = wide();
  const BundleResult result = adjust_bundle(model, scene, priors, {});
  const Eigen::Isometry3d T = model.T_colour_depth();
  EXPECT_LT(distance_between(T, truth.T_colour_depth), 0.002);
  EXPECT_LT(angle_between(T, truth.T_colour_depth), 0.1 * M_PI / 180);
  EXPECT_LT(std::abs(model.values[head::fx] / truth.colour.fx - 1), 0.003);
  EXPECT_LE(result.rounds, 10) << "rounds end when nothing moves any more";
  for (const auto p : {head::tx, head::ty, head::tz}) EXPECT_LT(result.sigmas[p], 0.003) << p;
}

TEST(SelfCalibration, FindsAnOffsetOfAllRanges) {
  RgbdCalibration truth = sharp(true_head()), start = truth;
  truth.depth_error.offset = 0.012;
  SceneObservations scene = seen_room(truth, rich_motion(), 400);
  HeadModel model(start);
  CalibrationPriors priors = wide();
  priors.depth_offset = 0.05;
  const BundleResult result = adjust_bundle(model, scene, priors, {});
  EXPECT_NEAR(observed_head(model, result, {}).calibration().depth_error.offset, 0.012, 5e-4);
  EXPECT_LT(distance_between(model.T_colour_depth(), truth.T_colour_depth), 5e-4);
}

// Each image's planes stay planes: only that the same walls are seen from elsewhere tells it.
TEST(SelfCalibration, FindsTheTiltOfRegisteredDepth) {
  RgbdCalibration truth = sharp(true_head(true)), start = truth;
  truth.depth_error.tilt_x = 0.012, truth.depth_error.tilt_y = -0.005;
  SceneObservations scene = seen_room(truth, rich_motion(), 400);
  HeadModel model(start);
  const BundleResult result = adjust_bundle(model, scene, wide(), {});
  const DepthError found = observed_head(model, result, {}).calibration().depth_error;
  EXPECT_NEAR(found.tilt_x, 0.012, 5e-4);
  EXPECT_NEAR(found.tilt_y, -0.005, 5e-4);
  EXPECT_FALSE(found.has_range_error());
}

// As a time-of-flight camera's wiggle does, of which the start knows nothing but that ranges err by as much.
TEST(SelfCalibration, RangesThatWiggleDoNotBendTheHead) {
  RgbdCalibration truth = true_head();
  truth.depth_noise = {0.005, 0, 0, 0};
  truth.depth_max = 7.5;
  const RgbdCalibration start = spoiled(truth);
  truth.depth_error.wiggle = 0.006, truth.depth_error.period = 1.9, truth.depth_error.phase = 1;
  SceneObservations scene = seen_room(truth, rich_motion(), 400), again = scene;
  HeadModel model(start), bent(start);
  const BundleResult result = adjust_bundle(model, scene, {}, {});
  const Eigen::Isometry3d T = model.T_colour_depth();
  EXPECT_LT(distance_between(T, truth.T_colour_depth), 0.002);
  EXPECT_LT(angle_between(T, truth.T_colour_depth), 0.1 * M_PI / 180);
  EXPECT_NEAR(model.values[head::cy], truth.colour.cy, 1);
  EXPECT_FALSE(is_observed(result, head::depth_offset, {})) << "the curve is one, too";

  CalibrationPriors sure;
  sure.range_curve = 0;
  adjust_bundle(bent, again, sure, {});
  EXPECT_GT(distance_between(bent.T_colour_depth(), truth.T_colour_depth), 0.002)
      << "the wiggle is too small to tell anything here";
}

// Noise that many pixels share. A curve by the range that was measured takes the noise along into a world
// that shrinks: the smaller it is, the less ranges seem to err.
TEST(SelfCalibration, NoisyRangesDoNotShrinkTheWorld) {
  RgbdCalibration truth = true_head();
  truth.depth_noise = {0.03, 0, 0, 0};
  const std::vector<Shot> shots = rich_motion();
  SceneObservations scene = seen_room(truth, shots, 1500);
  add_shared_noise(scene, 0.03, 9);
  HeadModel model(truth);
  adjust_bundle(model, scene, {}, {});
  double found = 0, way = 0;
  for (std::size_t k = 1; k < shots.size(); ++k) {
    found += distance_between(scene.keyframes[k - 1].T_world_camera, scene.keyframes[k].T_world_camera);
    way += distance_between(shots[k - 1].T_world_camera, shots[k].T_world_camera);
  }
  EXPECT_NEAR(found / way, 1, 0.003);
  EXPECT_NEAR(model.values[head::depth_offset], 0, 0.002);
}

// Wheels whose radii and track are 6 and 4 % off.
TEST(SelfCalibration, VelocitiesFollowThePathThatWasFound) {
  const RgbdCalibration truth = sharp(true_head());
  const std::vector<Shot> shots = rich_motion();
  SceneObservations scene = seen_room(truth, shots, 400);
  const auto told = [](Vector6d motion) {
    motion.head<3>() *= 1.06, motion.tail<3>() *= 0.96;
    return motion;
  };
  for (std::size_t k = 0; k < shots.size(); ++k) {
    scene.keyframes[k].twist = told(shots[k].twist);
    if (k > 0)
      scene.keyframes[k].motion =
          told(se3_log(shots[k - 1].T_world_camera.inverse() * shots[k].T_world_camera));
  }
  scene.keyframes[5].motion->tail<3>() += Eigen::Vector3d(0.05, 0, 0.05);  // a slip
  SceneObservations as_told = scene;
  for (ObservedKeyframe& keyframe : as_told.keyframes) keyframe.motion.reset();
  HeadModel model(spoiled(truth)), off(spoiled(truth));
  adjust_bundle(model, scene, wide(), {});
  adjust_bundle(off, as_told, wide(), {});
  EXPECT_GT(std::abs(off.values[head::colour_rows] - truth.rolling_shutter), 5e-4)
      << "with nothing to compare velocities to";
  EXPECT_NEAR(model.values[head::colour_rows], truth.rolling_shutter, 2e-4);
  EXPECT_NEAR(model.values[head::depth_clock], truth.depth_clock_offset, 1e-4);
  EXPECT_NEAR(scene.keyframes[3].twist(0), shots[3].twist(0), 2e-3);
}

/// A head that errs by nothing but its keyframes' turn rates, by 0.1 rad/s on each axis.
SceneObservations with_wrong_turn_rates(const RgbdCalibration& truth, double turn_noise) {
  SceneObservations scene = seen_room(truth, rich_motion(), 400);
  Random random(6);
  for (ObservedKeyframe& keyframe : scene.keyframes) {
    for (int i = 3; i < 6; ++i) keyframe.twist(i) += 0.1 * random.normal();
    keyframe.turn_noise = turn_noise;
  }
  return scene;
}

TEST(SelfCalibration, RowsTellTurnRatesThatWereToldWrongly) {
  const RgbdCalibration truth = sharp(true_head());
  const std::vector<Shot> shots = rich_motion();
  SceneObservations scene = with_wrong_turn_rates(truth, 0.1), as_told = with_wrong_turn_rates(truth, 0);
  HeadModel model(spoiled(truth)), off(spoiled(truth));
  adjust_bundle(model, scene, wide(), {});
  adjust_bundle(off, as_told, wide(), {});
  const auto turn_rate_errors = [&](const SceneObservations& s) {
    double squares = 0;
    for (std::size_t k = 0; k < shots.size(); ++k)
      squares += (s.keyframes[k].twist - shots[k].twist).tail<3>().squaredNorm();
    return std::sqrt(squares / static_cast<double>(3 * shots.size()));
  };
  EXPECT_LT(turn_rate_errors(scene), 0.02);
  EXPECT_GT(turn_rate_errors(as_told), 0.05);
  EXPECT_LT(distance_between(model.T_colour_depth(), truth.T_colour_depth), 5e-4);
  EXPECT_GT(distance_between(off.T_colour_depth(), truth.T_colour_depth), 1e-3);
  EXPECT_NEAR(model.values[head::colour_rows], truth.rolling_shutter, 4e-4);  // 3.1e-4, by what was told
  EXPECT_GT(std::abs(off.values[head::colour_rows] - truth.rolling_shutter), 6e-4);
}

TEST(SelfCalibration, AGlobalShutterTellsNothingOfTurnRates) {
  RgbdCalibration truth = sharp(true_head());
  truth.rolling_shutter = 0;
  const std::vector<Shot> shots = rich_motion();
  SceneObservations scene = with_wrong_turn_rates(truth, 0.1);
  const SceneObservations told = scene;
  HeadModel model(truth);
  adjust_bundle(model, scene, wide(), {});
  for (std::size_t k = 0; k < shots.size(); ++k)
    EXPECT_LT((scene.keyframes[k].twist - told.keyframes[k].twist).norm(), 1e-9) << k;
}

TEST(SelfCalibration, LeavesWhatIsHeld) {
  SceneObservations scene = seen_room(true_head(), rich_motion(), 200);
  HeadModel model(true_head());
  CalibrationPriors none;
  none.focal_length = none.aspect = none.principal_point = none.radial = none.tangential = none.third_radial =
      0;
  none.translation = none.rotation = none.depth_scale = none.depth_offset = 0;
  none.depth_clock = none.rolling_shutter = none.depth_tilt = 0;
  const BundleResult result = adjust_bundle(model, scene, none, {});
  EXPECT_EQ(model.values, HeadModel(true_head()).values);
  EXPECT_TRUE(result.covariance.isZero());
}

}  // namespace
}  // namespace lcmslam
