// What a drive must tell before `calibrate mount` writes what it found.

#include "tools/calibrate/drive_report.hpp"

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

}  // namespace
}  // namespace lcmslam
