#include <lcmslam/evaluation/map_placement.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace lcmslam {
namespace {

/// A drive along x that leaves the line by `bend` (m) to the left; the estimate goes up by 3 mm there.
std::vector<MatchedPose> drive_matches(double bend) {
  std::vector<MatchedPose> matches;
  for (int i = 0; i < 200; ++i) {
    const double x = 0.01 * i, side = std::sin(M_PI * x);
    const Eigen::Isometry3d truth = planar_pose(x, bend * side, 0.2 * side);
    Eigen::Isometry3d estimate = planar_pose(3, -2, 1.1) * truth;
    estimate.translation().z() += 0.003 * side;
    matches.push_back({10'000 * i, truth, estimate});
  }
  return matches;
}

double turned_degrees(const Eigen::Isometry3d& T_truth_estimate) {
  return rotation_angle(T_truth_estimate * planar_pose(3, -2, 1.1)) * 180 / M_PI;
}

TEST(MapPlacement, AStraightDriveIsPlacedByItsOrientationsToo) {
  const std::vector<MatchedPose> matches = drive_matches(0.002);
  EXPECT_GT(turned_degrees(find_alignment(matches, Alignment::se3).T_truth_estimate), 45);
  EXPECT_LT(turned_degrees(placed_by_poses(matches)), 0.5);
}

TEST(MapPlacement, AWidePathIsPlacedAsItsPositionsAre) {
  const std::vector<MatchedPose> matches = drive_matches(1);
  const Eigen::Isometry3d by_positions = find_alignment(matches, Alignment::se3).T_truth_estimate;
  EXPECT_LT(rotation_angle(placed_by_poses(matches) * by_positions.inverse()), 1e-3);
}

}  // namespace
}  // namespace lcmslam
