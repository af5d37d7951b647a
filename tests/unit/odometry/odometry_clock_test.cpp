#include <lcmslam/odometry/odometry_clock.hpp>

#include <gmock/gmock.h>
#include <cmath>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

constexpr double seconds = 40;

Utime stamp(double t) {
  return 1'000'000'000 + std::llround(1e6 * t);
}

/// A robot's bends, both ways; `bends`: 0 drives straight on.
double heading(double t, double bends) {
  return bends * (0.6 * std::sin(0.7 * t) + 0.2 * std::sin(1.9 * t + 1));
}

struct Drive {
  double late = 0;  // s that odometry's stamps are later than the camera's clock
  double bends = 1, scale = 1, noise = 0;
  int jump_every = 1 << 30;  // images: one that visual odometry gets wrong
  double gap = 0;            // s without odometry, in the middle
};

OdometryClock watched(const Drive& drive) {
  OdometryClock clock;
  Random random(2);
  Eigen::Isometry3d T_robot_camera = optical_axes();
  T_robot_camera.linear() = so3_exp({0.1, 0.35, -0.2}) * T_robot_camera.linear();
  for (int i = 0; i <= 50 * seconds; ++i) {
    const double t = 0.02 * i;
    if (t > 20 && t < 20 + drive.gap) continue;
    MotionSample sample;
    sample.utime = stamp(t + drive.late);
    sample.T_odom_robot = planar_pose(0.4 * t, 0, drive.scale * heading(t, drive.bends));
    clock.add_odometry(sample);
  }
  for (int i = 0; i <= 10 * seconds; ++i) {
    const double t = 0.1 * i + 0.0037;
    Eigen::Isometry3d T = planar_pose(0.4 * t, 0, heading(t, drive.bends)) * T_robot_camera;
    T.linear() = T.linear() *
                 so3_exp(drive.noise * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    if (i % drive.jump_every == drive.jump_every - 1) T.linear() = so3_exp({0.3, 0.4, -0.2}) * T.linear();
    clock.add_camera(stamp(t), T);
  }
  return clock;
}

TEST(OdometryClock, FindsTheOffsetOfBothSigns) {
  for (const double late : {-0.13, -0.02, 0.0, 0.02, 0.31}) {
    Drive drive;
    drive.late = late;
    const auto found = watched(drive).estimate();
    ASSERT_TRUE(found.known) << found.reason;
    EXPECT_NEAR(found.offset, -late, 3e-4) << "added to odometry's stamps it gives the camera's clock";
    EXPECT_GT(found.likeness, 0.999);
  }
}

TEST(OdometryClock, NeedsNoMountAndNoScale) {
  Drive drive;
  drive.late = 0.02;
  drive.scale = 1.04;
  drive.noise = 5e-4;
  const auto found = watched(drive).estimate();
  ASSERT_TRUE(found.known) << found.reason;
  EXPECT_NEAR(found.offset, -0.02, 0.003);
  EXPECT_NEAR(found.scale, 1 / 1.04, 0.005);
  EXPECT_LT(std::abs(found.offset + 0.02), 4 * found.sigma);
}

TEST(OdometryClock, SaysThatAStraightWayTellsNothing) {
  Drive drive;
  drive.bends = 0;
  const auto found = watched(drive).estimate();
  EXPECT_FALSE(found.known);
  EXPECT_THAT(found.reason, HasSubstr("hardly turned"));
}

TEST(OdometryClock, SaysThatNoiseLeavesItOpen) {
  Drive drive;
  drive.bends = 0.05;
  drive.noise = 0.05;
  const auto found = watched(drive).estimate();
  EXPECT_FALSE(found.known) << found.offset << " +- " << found.sigma;
}

TEST(OdometryClock, IsNotLedAstrayByAJumpOfTheCamera) {
  Drive drive;
  drive.late = 0.02;
  drive.jump_every = 25;
  const auto found = watched(drive).estimate();
  ASSERT_TRUE(found.known) << found.reason;
  EXPECT_NEAR(found.offset, -0.02, 1e-3);
}

TEST(OdometryClock, SaysWhatItLacks) {
  EXPECT_THAT(OdometryClock().estimate().reason, HasSubstr("steps"));
}

// Offsets at which a step falls into the gap are no better than others.
TEST(OdometryClock, AGapInOdometryIsNoOffset) {
  for (const double gap : {0.3, 0.45, 0.56, 0.6, 0.7, 0.9, 2.0}) {
    Drive drive;
    drive.late = 0.02;
    drive.gap = gap;
    const auto found = watched(drive).estimate();
    ASSERT_TRUE(found.known) << found.reason;
    EXPECT_NEAR(found.offset, -0.02, 1e-3) << gap;
    EXPECT_GT(found.sigma, 1e-9) << gap;
  }
}

}  // namespace
}  // namespace lcmslam
