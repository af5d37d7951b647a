#include <lcmslam/geometry/ground_plane.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

Vector6d off(double height, double roll, double pitch) {
  Vector6d xi = Vector6d::Zero();
  xi.segment<3>(2) << height, roll, pitch;
  return xi;
}

Eigen::Isometry3d pose_off(double height, double roll, double pitch) {
  return planar_pose(3, -2, 2.1) * se3_exp(off(height, roll, pitch));
}

Matrix6d covariance(double height, double tilt) {
  Vector6d sigmas;
  sigmas << 0.02, 0.02, height, tilt, tilt, 0.01;
  return sigmas.cwiseAbs2().asDiagonal();
}

TEST(GroundPlane, TellsHeightRollAndPitch) {
  EXPECT_LT((off_ground(pose_off(0.05, 0.02, -0.03)) - Eigen::Vector3d(0.05, 0.02, -0.03)).norm(), 1e-3);
  EXPECT_LT(off_ground(planar_pose(4, 5, -2)).norm(), 1e-12);
  EXPECT_LT(off_ground(on_ground(pose_off(0.05, 0.02, -0.03))).norm(), 1e-12);
  EXPECT_NEAR(levelled(pose_off(0.05, 0.02, -0.03)).translation().z(), 0.05, 1e-3);
  EXPECT_LT(off_ground(levelled(pose_off(0.05, 0.02, -0.03))).tail<2>().norm(), 1e-12);
}

TEST(GroundContact, ARampFreesAndAnotherFloorIsLevel) {
  const GroundContact ground({});
  const Matrix6d P = covariance(0.005, 0.002);
  EXPECT_EQ(ground.seen(pose_off(0.01, 0.003, -0.003), P), Floor::plane);
  EXPECT_EQ(ground.seen(pose_off(0.14, 0.003, -0.003), P), Floor::level);
  EXPECT_EQ(ground.seen(pose_off(0.01, 0.0, -0.1), P), Floor::free);
  EXPECT_EQ(ground.seen(pose_off(0.01, 0.03, 0), P), Floor::free);
  EXPECT_EQ(ground.seen(pose_off(0.14, 0.03, -0.1), covariance(1, 1)), Floor::plane);  // nobody knows better
}

// What is flat is refused as seldom as the gate says: 0.1 % by tilt, 0.02 % by height.
TEST(GroundContact, RefusesAFlatFloorAsSeldomAsItsGateSays) {
  const GroundSettings s;
  const GroundContact ground(s);
  Random random(5);
  for (const double ratio : {0.3, 1.0, 3.0}) {  // of the measurement's sigma and the plane's
    const Matrix6d P = covariance(ratio * s.height, ratio * s.tilt);
    constexpr int draws = 20'000;
    int seen = 0, left_over = 0;
    for (int i = 0; i < draws; ++i) {
      const Eigen::Vector3d R(s.height, s.tilt, s.tilt);
      Eigen::Vector3d truth, measured;
      for (int k = 0; k < 3; ++k) {
        truth(k) = R(k) * random.normal();
        measured(k) = truth(k) + ratio * R(k) * random.normal();
      }
      seen += ground.seen(pose_off(measured.x(), measured.y(), measured.z()), P) != Floor::plane;
      const double kept =
          1 / (1 + ratio * ratio);  // of the measurement in an estimate that the plane is part of
      const Eigen::Vector3d both = kept * measured;
      const double sigma = ratio * std::sqrt(kept);
      left_over += ground.left_over(pose_off(both.x(), both.y(), both.z()),
                                    covariance(sigma * s.height, sigma * s.tilt)) != Floor::plane;
    }
    EXPECT_GT(seen, 0.0003 * draws) << ratio;
    EXPECT_LT(seen, 0.0025 * draws) << ratio;
    EXPECT_LT(left_over, 0.0025 * draws) << ratio;
    if (ratio <= 1) {
      EXPECT_GT(left_over, 0.0003 * draws) << ratio;
    }
  }
}

TEST(GroundContact, ComesBackFloorByFloor) {
  GroundSettings s;
  s.return_after = 3;
  GroundContact ground(s);
  const Matrix6d P = covariance(0.003, 0.001);
  ground.leave_for(Floor::free);
  EXPECT_GT(ground.sigmas().minCoeff(), 100);
  const auto steps = [&](int count, double height, double tilt) {
    for (int i = 0; i < count; ++i) ground.observe(pose_off(height, tilt, 0), P);
    return ground.floor();
  };
  EXPECT_EQ(steps(20, 0.14, 0.1), Floor::free);   // on the ramp
  EXPECT_EQ(steps(2, 0.14, 0.001), Floor::free);  // on the landing
  EXPECT_EQ(steps(1, 0.14, 0.1), Floor::free);
  EXPECT_EQ(steps(3, 0.14, 0.001), Floor::level);
  EXPECT_EQ(ground.sigmas().y(), s.tilt);
  EXPECT_GT(ground.sigmas().x(), 100);
  EXPECT_EQ(steps(20, 0.14, 0.001), Floor::level);
  EXPECT_EQ(steps(3, 0.005, 0.001), Floor::plane);
  EXPECT_EQ(ground.sigmas().x(), s.height);
}

}  // namespace
}  // namespace lcmslam
