// The errors that an ensemble's sensors make are those that the noise states, and hold together as told.

#include <lcmslam/fastslam/sensor_error.hpp>

#include <gtest/gtest.h>

#include "tests/support/heap_allocations.hpp"

namespace lcmslam {
namespace {

constexpr double range = 2.5;

FastSlamSettings without_calibration_errors() {
  FastSlamSettings settings;
  settings.focal_sigma = settings.stamp_sigma = settings.shutter_sigma = 0;
  settings.slide_sigma = settings.bend_sigma = 0;
  return settings;
}

/// A camera that looks forward and one feature in its middle.
class SensorErrorTest : public ::testing::Test {
 protected:
  SensorErrorTest() {
    frame_.height = 480;
    Feature feature;
    feature.y = 0;  // the first row
    feature.kind = MeasurementKind::point;
    feature.depth_sigma = 0.01F;
    frame_.features.push_back(feature);
    point_.measurement.value << range, 0, 0;
    stated_.diagonal() << 1e-4, 4e-6, 4e-6;
    point_.measurement.covariance = FastSlamSettings().measurement_inflation * stated_;
  }
  EnsembleVectors draw(SensorError& errors, SensorError::Landmark landmark, double heading = 0,
                       const Vector6d& twist = Vector6d::Zero()) const {
    return errors.draw(point_, frame_, landmark, planar_pose(0, 0, heading), twist);
  }
  /// Of two that draw the same but for one error.
  EnsembleVectors difference(SensorError& with, SensorError& without, SensorError::Landmark landmark,
                             const Eigen::Isometry3d& T_world_robot) const {
    const Vector6d still = Vector6d::Zero();
    return with.draw(point_, frame_, landmark, T_world_robot, still) -
           without.draw(point_, frame_, landmark, T_world_robot, still);
  }
  static double mean_product(const EnsembleVectors& a, const EnsembleVectors& b, int row) {
    return static_cast<double>(a.row(row).dot(b.row(row))) / ensemble_size;
  }

  FeatureFrame frame_;
  FeaturePoint point_;
  Eigen::Matrix3d stated_ = Eigen::Matrix3d::Zero();
};

TEST_F(SensorErrorTest, IsAsLargeAsTheNoiseStates) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  constexpr int seeds = 30;
  for (int seed = 1; seed <= seeds; ++seed) {
    FastSlamSettings settings = without_calibration_errors();
    settings.seed = static_cast<std::uint64_t>(seed);
    SensorError errors(settings);
    const Eigen::Matrix<double, 3, ensemble_size> e = draw(errors, {1, 1}).cast<double>();
    sum += e * e.transpose() / (seeds * ensemble_size);
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sum(i, i), stated_(i, i), 0.1 * stated_(i, i));
  EXPECT_NEAR(sum(0, 1), 0, 0.1 * std::sqrt(stated_(0, 0) * stated_(1, 1)));
}

// A robot that has turned left and gone 2 m aside of where it first saw two landmarks: each member has both
// slide along by the same ratio of that way, and a third that is new by nothing.
TEST_F(SensorErrorTest, LandmarksSlideByARatioOfTheWaySinceTheyWereFirstSeen) {
  FastSlamSettings settings = without_calibration_errors();
  settings.slide_sigma = 0.01;
  SensorError still(without_calibration_errors()), sliding(settings);
  const auto slide = [&](int landmark, const Eigen::Isometry3d& T_world_robot) {
    return difference(sliding, still, {landmark, landmark}, T_world_robot);
  };
  const Eigen::Isometry3d first = planar_pose(1, 1, 0), later = planar_pose(1, 3, M_PI / 2);
  EXPECT_LT(slide(1, first).norm(), 1e-6F);
  EXPECT_LT(slide(2, first).norm(), 1e-6F);
  const EnsembleVectors one = slide(1, later), two = slide(2, later);
  EXPECT_LT((one - two).norm(), 1e-5F);
  EXPECT_NEAR(mean_product(one, one, 0), std::pow(0.01 * 2, 2), 0.4 * std::pow(0.01 * 2, 2));  // ahead now
  EXPECT_LT(one.row(1).norm() + one.row(2).norm(), 1e-5F);
  EXPECT_LT(slide(3, later).norm(), 1e-6F);
}

// Landmarks come and go by the million; what is kept for them is as much as there are at a time.
TEST_F(SensorErrorTest, ALandmarkInTheSlotOfADeadOneBeginsItsOwnWay) {
  FastSlamSettings settings = without_calibration_errors();
  settings.slide_sigma = 0.01;
  SensorError still(without_calibration_errors()), sliding(settings);
  for (int id = 1; id <= 3; ++id) {
    EXPECT_LT(difference(sliding, still, {5, id}, planar_pose(id, 0, 0)).norm(), 1e-6F) << id;
    EXPECT_GT(difference(sliding, still, {5, id}, planar_pose(id + 1, 0, 0)).norm(), 1e-3F) << id;
  }
  const long before = heap_allocations();
  for (int id = 4; id <= 1000; ++id) draw(sliding, {5, id});
  EXPECT_EQ(heap_allocations(), before);
}

// The same robot: each member turns both landmarks about it by the same angle, whichever way it went.
TEST_F(SensorErrorTest, LandmarksBendTheWaySinceTheyWereFirstSeen) {
  FastSlamSettings settings = without_calibration_errors();
  settings.bend_sigma = 0.01;
  SensorError straight(without_calibration_errors()), bent(settings);
  const auto bend = [&](int landmark, const Eigen::Isometry3d& T_world_robot) {
    return difference(bent, straight, {landmark, landmark}, T_world_robot);
  };
  const Eigen::Isometry3d first = planar_pose(1, 1, 0);
  EXPECT_LT(bend(1, first).norm() + bend(2, first).norm(), 1e-6F);
  const EnsembleVectors aside = bend(1, planar_pose(1, 3, M_PI / 2)), back = bend(2, planar_pose(-1, 1, 0));
  EXPECT_LT((aside - back).norm(), 1e-5F);
  const double expected = std::pow(0.01 * 2 * range, 2);
  EXPECT_NEAR(mean_product(aside, aside, 1), expected, 0.4 * expected);
  EXPECT_LT(aside.row(0).norm() + aside.row(2).norm(), 1e-5F);
  EXPECT_LT(bend(3, planar_pose(-1, 1, 0)).norm(), 1e-6F);
}

// Between two images: all of the depth's systematic part, for every landmark; the feature's own part as long
// as the view is the same.
TEST_F(SensorErrorTest, HoldsTogetherAsTold) {
  FastSlamSettings settings = without_calibration_errors();
  settings.systematic_depth = 0.6;  // as large as the rest, so that neither hides in the other's scatter
  double same_view = 0, other_view = 0, other_landmark = 0, own_same = 0, own_other = 0;
  SensorError errors(settings);
  constexpr int landmarks = 200;
  for (int landmark = 0; landmark < landmarks; ++landmark) {
    const EnsembleVectors a = draw(errors, {landmark, landmark}), b = draw(errors, {landmark, landmark});
    const EnsembleVectors turned = draw(errors, {landmark, landmark}, 4 * settings.view_step);
    same_view += mean_product(a, b, 0) / landmarks;
    other_view += mean_product(a, turned, 0) / landmarks;
    other_landmark += mean_product(a, draw(errors, {landmark + 1000, landmark + 1000}), 0) / landmarks;
    own_same += mean_product(a, b, 1) / landmarks;
    own_other += mean_product(a, turned, 1) / landmarks;
  }
  const double systematic = settings.systematic_depth * settings.systematic_depth * stated_(0, 0);
  const double lasting = settings.view_share * (stated_(0, 0) - systematic);
  EXPECT_NEAR(other_landmark, systematic, 0.4 * systematic);  // the mean square of 64 waves at one range
  EXPECT_NEAR(other_view, other_landmark, 0.1 * systematic);
  EXPECT_NEAR(same_view - other_landmark, lasting, 0.1 * lasting);
  EXPECT_NEAR(own_same, settings.view_share * stated_(1, 1), 0.1 * stated_(1, 1));
  EXPECT_NEAR(own_other, 0, 0.1 * stated_(1, 1));
}

// The first row of a shutter that rolls was taken half its time before: a turning robot sees it aside.
TEST_F(SensorErrorTest, OfTimeGrowsWithTheVelocity) {
  FastSlamSettings still = without_calibration_errors(), rolling = still;
  rolling.shutter_sigma = 0.03;
  Vector6d twist = Vector6d::Zero();
  twist(5) = 1;
  SensorError a(still), b(rolling);
  const EnsembleVectors by_time = draw(b, {1, 1}, 0, twist) - draw(a, {1, 1}, 0, twist);
  const double expected = 0.5 * 0.03 * range;
  EXPECT_NEAR(std::sqrt(mean_product(by_time, by_time, 1)), expected, 0.25 * expected);
  EXPECT_NEAR(mean_product(by_time, by_time, 0), 0, 1e-12);
  const EnsembleVectors standing = draw(b, {2, 2}) - draw(a, {2, 2});
  EXPECT_EQ(standing, EnsembleVectors::Zero());
}

}  // namespace
}  // namespace lcmslam
