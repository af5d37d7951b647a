#include <lcmslam/ros/truth_body.hpp>

#include <gmock/gmock.h>

namespace lcmslam::ros {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

Eigen::Isometry3d shifted(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// A robot with markers, a head on a neck that turns, and a camera on it with a prism beside its lens.
TransformTree robot_with_markers() {
  TransformTree tree;
  const auto add = [&](const char* parent, const char* child, const Eigen::Isometry3d& T) {
    tree.add({{1000, parent}, child, T});
  };
  add("base_link", "markers", shifted(0, 0, 1.5));
  for (const double angle : {0.0, 0.4}) add("base_link", "head", planar_pose(0.1, 0, angle));
  add("head", "colour", shifted(0, 0.02, 0));
  add("colour", "prism", shifted(0, -0.05, 0));
  for (const double x : {0.0, 3.0}) add("odom", "base_link", shifted(x, 0, 0));
  return tree;
}

TruthBody body_of(const std::string& frame, const std::string& robot = "base_link") {
  return find_truth_body(frame, robot, "colour", robot_with_markers());
}

TEST(TruthBody, TheRobotsIsTakenAsItIs) {
  const TruthBody truth = body_of("base_link");
  EXPECT_EQ(truth.body, "robot");
  EXPECT_TRUE(truth.T_told_body.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_THAT(truth.note, IsEmpty());
}

TEST(TruthBody, TheCamerasIsTheCameras) {
  for (const char* robot : {"base_link", ""}) {
    EXPECT_EQ(body_of("colour", robot).body, "camera");
    EXPECT_THAT(body_of("colour", robot).note, HasSubstr("colour camera's"));
  }
}

TEST(TruthBody, WhatSitsStillOnTheRobotOrTheCameraIsBroughtThere) {
  const TruthBody markers = body_of("markers"), prism = body_of("prism");
  EXPECT_EQ(markers.body, "robot");
  EXPECT_TRUE(markers.T_told_body.isApprox(shifted(0, 0, -1.5)));
  EXPECT_THAT(markers.note, HasSubstr("of markers: brought to base_link, by tf 1.500 m"));
  EXPECT_EQ(prism.body, "camera") << "between it and the robot is a joint";
  EXPECT_TRUE(prism.T_told_body.isApprox(shifted(0, 0.05, 0)));
}

TEST(TruthBody, WhatNobodyPlacesIsSaid) {
  for (const char* frame : {"helmet", "odom"}) {
    const TruthBody truth = body_of(frame);
    EXPECT_EQ(truth.body, "robot");
    EXPECT_TRUE(truth.T_told_body.isApprox(Eigen::Isometry3d::Identity())) << frame;
    EXPECT_THAT(truth.note,
                HasSubstr(std::string("of ") + frame + ", and where that sits on the robot nobody"));
  }
  EXPECT_THAT(body_of("").note, HasSubstr("do not say whose they are: taken as the robot's"));
}

}  // namespace
}  // namespace lcmslam::ros
