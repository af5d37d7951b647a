// The fastslam process with visual odometry, when its camera is covered for five seconds of a drive.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <iostream>

#include <lcmslam/fastslam/pose_space.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "tests/support/recorded_drive.hpp"

namespace lcmslam {
namespace {

using testing::RecordedDrive;
using testing::TestBus;

constexpr double covered = 9.9, uncovered = 14.9, patience = 1;  // s after the drive's start

/// With `source` of odometry; dark or not.
std::vector<pose_estimate_t> drive(const std::string& source, bool dark) {
  TestBus bus;
  bus.add<OdometryNode>(ConfigNode::parse("{source: " + source + "}"));
  bus.add<FastSlamNode>();
  RecordedDrive::Part part;
  part.from = 0;
  part.with_features = true;
  if (dark) part.covered = {covered, uncovered};
  RecordedDrive::instance().play(bus, part);
  return bus.on<pose_estimate_t>("FASTSLAM_POSE");
}

class CoveredCamera : public ::testing::TestWithParam<const char*> {};

TEST_P(CoveredCamera, SaysSoStaysWhereItIsAndFindsBack) {
  const bool wheels = GetParam() == std::string("wheels");
  const auto seeing = drive(GetParam(), false), poses = drive(GetParam(), true);
  ASSERT_EQ(poses.size(), seeing.size());
  ASSERT_GT(poses.size(), 70U);
  double last_error = 1, worst_nees = 0;
  int dark = 0, lost = 0;
  bool found = wheels;  // never lost
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double seconds = 1e-6 * static_cast<double>(poses[i].utime - poses.front().utime);
    const Eigen::Isometry3d T = from_message(poses[i].T_map_robot, "T_map_robot");
    const Eigen::Isometry3d error = T.inverse() * from_message(seeing[i].T_map_robot, "T_map_robot");
    last_error = error.translation().norm();
    if (seconds < covered) continue;
    const Eigen::Matrix3d P =
        PoseSpace<3>::reduce(covariance_from_message(poses[i].covariance, "covariance"));
    const Eigen::Vector3d e = PoseSpace<3>::reduce(se3_log(error));
    worst_nees = std::max(worst_nees, e.dot(P.ldlt().solve(e)));
    if (seconds < uncovered) {
      ++dark;
      lost += poses[i].status == pose_estimate_t::LOST;
      EXPECT_NE(poses[i].status, pose_estimate_t::TRACKING) << seconds;
      if (seconds > covered + patience) {
        EXPECT_EQ(poses[i].status, pose_estimate_t::LOST) << seconds << ", whatever the odometry knows";
      }
    } else {
      found |= poses[i].status == pose_estimate_t::RELOCALISED;
      if (poses[i].status == pose_estimate_t::TRACKING) {
        EXPECT_TRUE(found) << seconds;
        EXPECT_LT(last_error, wheels ? 0.3 : 0.05) << seconds;  // it maps on where the wheels say
      }
    }
  }
  std::cout << lost << " of " << dark << " dark frames lost, worst NEES " << worst_nees << ", " << last_error
            << " m at the end\n";
  EXPECT_EQ(dark, 15);
  EXPECT_LT(worst_nees, 12);
  EXPECT_TRUE(found);
  EXPECT_LT(last_error, 0.05);
}

INSTANTIATE_TEST_SUITE_P(Odometry, CoveredCamera, ::testing::Values("wheels", "visual"));

}  // namespace
}  // namespace lcmslam
