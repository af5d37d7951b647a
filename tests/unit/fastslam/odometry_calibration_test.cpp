// What is systematic in an odometry's error.

#include <lcmslam/fastslam/odometry_calibration.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

Motion driven(double way, double side, double turn) {
  Motion motion;
  Vector6d twist = Vector6d::Zero();
  twist << way, side, 0, 0, 0, turn;
  motion.T_from_to = se3_exp(twist);
  motion.covariance = 1e-8 * Matrix6d::Identity();
  return motion;
}

// Seen from a frame that is turned on the base, a motion is D^-1 T D.
TEST(OdometryCalibration, HoldsAHeadThatLooksAside) {
  const double looks_left = 0.005;
  const Eigen::Isometry3d D = planar_pose(0, 0, looks_left);
  OdometryCalibration calibration((FastSlamSettings()));
  CalibrationMean mean = CalibrationMean::Zero();
  mean(3) = -looks_left;
  for (const auto& [way, side, turn] : {std::array{0.3, 0.0, 0.0}, {0.2, -0.1, 0.4}, {-0.3, 0.1, -0.5}}) {
    calibration.begin(driven(way, side, turn));
    const Eigen::Isometry3d T = driven(way, side, turn).T_from_to;
    const Vector6d left = se3_log(calibration.apply(mean).inverse() * (D.inverse() * T * D));
    const Vector6d without = se3_log(T.inverse() * (D.inverse() * T * D));
    EXPECT_LT(left.norm(), 0.05 * without.norm()) << way << " " << side << " " << turn;
  }
}

TEST(OdometryCalibration, IsLearnedFromMotionsThatGoEveryWay) {
  const FastSlamSettings settings;
  const CalibrationMean sigma = calibration_sigmas(settings);
  ASSERT_GT(sigma.minCoeff(), 0);
  Random random(1, 7);
  CalibrationMean truth;
  for (int i = 0; i < calibration_size; ++i) truth(i) = sigma(i) * (i % 2 == 0 ? 1.5 : -1.5);
  OdometryCalibration calibration(settings);
  CalibrationMean mean = CalibrationMean::Zero();
  const CalibrationCovariance before = calibration.covariance();
  for (int step = 0; step < 100; ++step) {
    const Motion odometry = driven(random.uniform(-0.2, 0.2), 0, random.uniform(-0.3, 0.3));
    calibration.begin(odometry);
    calibration.prepare_gain(odometry.covariance);
    const Eigen::Isometry3d T_true = calibration.apply(truth);
    calibration.learn(se3_log(calibration.apply(mean).inverse() * T_true), mean);
    calibration.end();
  }
  for (int i = 0; i < calibration_size; ++i) {
    EXPECT_NEAR(mean(i), truth(i), 0.1 * sigma(i)) << i;
    EXPECT_LT(calibration.covariance()(i, i), 0.05 * before(i, i)) << i;
  }
}

}  // namespace
}  // namespace lcmslam
