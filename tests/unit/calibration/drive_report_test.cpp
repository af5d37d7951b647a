// What a drive must tell before `calibrate mount` writes what it found.

#include "tools/calibrate/drive_report.hpp"

#include <gmock/gmock.h>

#include "tests/support/camera_drive.hpp"

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

RecordedDrive tracked_drive() {
  RecordedDrive drive;
  drive.images = drive.tracked = 300;
  return drive;
}

/// A head that looks ahead, with sigmas of 2 mm and 1 mrad but for its height.
DriveCalibration found_mount(double height_sigma) {
  DriveCalibration found;
  found.T_robot_camera.linear() = optical_axes().linear();
  found.height_observed = true;
  Vector6d sigmas;
  sigmas << 0.002, height_sigma, 0.002, 0.001, 0.001, 0.001;  // the camera's y axis points down
  found.covariance = sigmas.cwiseAbs2().asDiagonal();
  return found;
}

TEST(MountDoubts, AreNoneOfAGoodDrive) {
  EXPECT_THAT(mount_doubts(tracked_drive(), found_mount(0.002)), IsEmpty());
}

TEST(MountDoubts, AHeightThatTheFloorDoesNotTellIsRefused) {
  EXPECT_THAT(mount_doubts(tracked_drive(), found_mount(0.169)), ElementsAre(HasSubstr("169 mm")));
}

TEST(MountDoubts, AHeightThatNobodyLookedForIsTheStarts) {
  DriveCalibration found = found_mount(1);
  found.height_observed = false;
  EXPECT_THAT(mount_doubts(tracked_drive(), found), IsEmpty());
}

/// As found_mount(0.002), and two wheels known to 0.1 %.
DriveCalibration found_wheels(std::vector<double> radius_factors, double layout_factor) {
  DriveCalibration found = found_mount(0.002);
  found.radius_factors = std::move(radius_factors);
  found.layout_factor = layout_factor;
  found.factor_covariance = 1e-6 * Eigen::Matrix3d::Identity();
  return found;
}

TEST(DriveDoubts, FactorsThatNoWheelHasAreRefused) {
  EXPECT_THAT(wheels_doubts(tracked_drive(), found_wheels({0.55, 1.9}, 1.9)), IsEmpty());
  for (const auto& found : {found_wheels({0.98, 0.4}, 1), found_wheels({2.1, 1}, 1),
                            found_wheels({1, 1}, 0.4), found_wheels({1, 1}, 2.1)}) {
    EXPECT_THAT(wheels_doubts(tracked_drive(), found), ElementsAre(HasSubstr("rough mount")));
    EXPECT_THAT(mount_doubts(tracked_drive(), found), ElementsAre(HasSubstr("rough mount")));
  }
}

TEST(DriveDoubts, ACameraThatIsLostMostOfTheTimeIsRefused) {
  RecordedDrive drive = tracked_drive();
  drive.tracked = drive.images / 2;
  EXPECT_THAT(mount_doubts(drive, found_wheels({1, 1}, 1)), IsEmpty());
  EXPECT_THAT(wheels_doubts(drive, found_wheels({1, 1}, 1)), IsEmpty());
  --drive.tracked;
  EXPECT_THAT(mount_doubts(drive, found_wheels({1, 1}, 1)), ElementsAre(HasSubstr("less than half")));
  EXPECT_THAT(wheels_doubts(drive, found_wheels({1, 1}, 1)), ElementsAre(HasSubstr("less than half")));
}

// Sigmas and misfit are of those that agree, however few.
TEST(DriveDoubts, WhatMostStretchesContradictIsRefused) {
  DriveCalibration found = found_wheels({1, 1}, 1);
  found.stretches = 40, found.slips = 20;
  EXPECT_THAT(mount_doubts(tracked_drive(), found), IsEmpty());
  EXPECT_THAT(wheels_doubts(tracked_drive(), found), IsEmpty());
  found.slips = 21;
  EXPECT_THAT(mount_doubts(tracked_drive(), found), ElementsAre(HasSubstr("disagree in 21 of 40 stretches")));
  EXPECT_THAT(wheels_doubts(tracked_drive(), found),
              ElementsAre(HasSubstr("disagree in 21 of 40 stretches")));
}

TEST(DriveDoubts, WheelsThatTurnBackwardsAreNoCameraThatLooksAhead) {
  const DrivenPath path(testing::figure_of_eight(4));
  const Eigen::Isometry3d backwards = Eigen::Translation3d(0.12, -0.03, 1.3) *
                                      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitY()) * optical_axes();
  const DriveCalibration found =
      calibrate_drive(cut_drive(testing::seen_motion(path, backwards, 1'000'000, 2),
                                wheel_steps(simulate_encoders(path, "differential", 1'000'000, 2))),
                      std::nullopt, optical_axes());
  if (angle_between(found.T_robot_camera, backwards) < 0.02) return;  // the truth was found all the same
  EXPECT_THAT(mount_doubts(tracked_drive(), found), Not(IsEmpty()));
  EXPECT_THAT(wheels_doubts(tracked_drive(), found), Not(IsEmpty()));
}

}  // namespace
}  // namespace lcmslam
