#include <lcmslam/evaluation/body_offset.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/recordings.hpp"
#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

std::vector<MatchedPose> matches_of(const Trajectory& truth, const Trajectory& estimate) {
  return associate(truth, estimate);
}

/// A robot in the plane that drives curves.
Trajectory planar_path(int poses = 300) {
  Trajectory path;
  for (int i = 0; i < poses; ++i) {
    const double s = 0.02 * i;
    path.push_back({1'000'000 + 33'000L * i, planar_pose(2 * std::sin(s), 1.5 * std::sin(2 * s),
                                                         std::atan2(3 * std::cos(2 * s), 2 * std::cos(s)))});
  }
  return path;
}

/// Of a camera that looks down a little.
Eigen::Isometry3d mount(double x, double height, double pitch) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T = T * optical_axes();
  T.translation() = Eigen::Vector3d(x, 0.05, height);
  return T;
}

class BodyOffsetOf : public ::testing::Test {
 protected:
  /// Both in worlds of their own, with noise.
  std::optional<BodyOffset> find(const Trajectory& truth, const Trajectory& estimate) {
    return find_body_offset(matches_of(
        truth,
        testing::moved(testing::with_noise(estimate, random_, 0.01, 0.02), testing::random_pose(random_))));
  }
  Random random_{7};
};

TEST_F(BodyOffsetOf, TheSameBodyIsNothing) {
  for (const Trajectory& path : {testing::curved_path(300), planar_path()}) EXPECT_FALSE(find(path, path));
}

TEST_F(BodyOffsetOf, CameraAgainstRobotIsFoundBothWays) {
  for (const Trajectory& robot : {testing::curved_path(300), planar_path()}) {
    const Trajectory camera = in_other_frame(robot, mount(0.3, 1.2, 0.2));
    const auto truth_is_camera = find(camera, robot);
    ASSERT_TRUE(truth_is_camera);
    EXPECT_TRUE(truth_is_camera->rotated);
    EXPECT_EQ(body_pair(*truth_is_camera), BodyPair::truth_is_camera);
    EXPECT_EQ(truth_is_camera->axes(), (std::array<std::string, 3>{"-y", "-z", "+x"}));
    EXPECT_NEAR(truth_is_camera->angle, 2 * M_PI / 3, 0.2);
    const auto estimate_is_camera = find(robot, camera);
    ASSERT_TRUE(estimate_is_camera);
    EXPECT_EQ(body_pair(*estimate_is_camera), BodyPair::estimate_is_camera);
  }
}

TEST_F(BodyOffsetOf, LeverIsMeasured) {
  const Trajectory robot = testing::curved_path(300);
  Eigen::Isometry3d lever = Eigen::Isometry3d::Identity();
  lever.translation() = Eigen::Vector3d(0.3, -0.1, 0.2);
  const auto offset = find(in_other_frame(robot, lever), robot);
  ASSERT_TRUE(offset);
  EXPECT_FALSE(offset->rotated);
  ASSERT_TRUE(offset->displaced);
  EXPECT_LT((offset->T_estimate_truth.translation() - lever.translation()).norm(), 0.02);
  EXPECT_EQ(body_pair(*offset), BodyPair::same);
}

TEST_F(BodyOffsetOf, OfAPlaneThatPartIsMeasuredThatTheMotionShows) {
  const Trajectory robot = planar_path();
  Eigen::Isometry3d lever = Eigen::Isometry3d::Identity();
  lever.translation() = Eigen::Vector3d(0.4, 0, 1.5);
  const auto offset = find(in_other_frame(robot, lever), robot);
  ASSERT_TRUE(offset && offset->displaced);
  EXPECT_NEAR(offset->T_estimate_truth.translation().x(), 0.4, 0.03);
}

TEST_F(BodyOffsetOf, OtherAxesAreNamed) {
  const Trajectory robot = testing::curved_path(300);
  Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
  turned.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const auto offset = find(in_other_frame(robot, turned), robot);
  ASSERT_TRUE(offset);
  EXPECT_EQ(body_pair(*offset), BodyPair::other);
  EXPECT_EQ(offset->axes(), (std::array<std::string, 3>{"+y", "-x", "+z"}));
}

// Along a line and without turning nobody can tell a turned body from a turned world.
TEST_F(BodyOffsetOf, AStraightWayTellsNothing) {
  Trajectory line;
  for (int i = 0; i < 100; ++i) line.push_back({1'000'000 + 33'000L * i, planar_pose(0.05 * i, 0, 0)});
  EXPECT_FALSE(find(line, line));
}

// An estimate that goes astray has errors, and they are its own.
TEST_F(BodyOffsetOf, DriftIsNoOffset) {
  for (const double turn : {0.0005, -0.001}) {
    Trajectory estimate;
    const Trajectory truth = planar_path();
    for (std::size_t i = 0; i < truth.size(); ++i) {
      StampedPose pose = truth[i];
      pose.T_world_body =
          planar_pose(0.001 * static_cast<double>(i), 0, turn * static_cast<double>(i)) * pose.T_world_body;
      estimate.push_back(pose);
    }
    EXPECT_FALSE(find(truth, estimate)) << turn;
  }
}

TEST_F(BodyOffsetOf, FewPosesTellNothing) {
  const Trajectory path = testing::curved_path(9);
  EXPECT_FALSE(find(path, in_other_frame(path, optical_axes())));
}

TEST_F(BodyOffsetOf, PublishedEstimatesOfTheSameBodyAreNothing) {
  LCMSLAM_SKIP_WITHOUT("trajectories");
  const auto folder = recording_path("trajectories");
  for (const auto& [truth, estimate] :
       {std::pair("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt"),
        std::pair("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam_drift.txt"),
        std::pair("fr2_desk_groundtruth.txt", "fr2_desk_ORB.txt")}) {
    const auto found = find_body_offset(associate(read_tum(folder / truth), read_tum(folder / estimate)));
    EXPECT_FALSE(found) << estimate << (found ? found->angle : 0) << " rad " << (found ? found->lever : 0)
                        << " m";
  }
}

}  // namespace
}  // namespace lcmslam
