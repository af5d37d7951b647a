// Before the first landmark: a robot that drives in the dark, or along bare walls. And one whose odometry
// stalls.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam {
namespace {

/// Drives at half a metre a second; its wheels' driver restarts after five.
class DarkDrive : public ::testing::Test {
 protected:
  static constexpr Utime frame_period = 100'000, wheel_period = 20'000;

  void drive(double seconds, std::int64_t sender) {
    const Utime end = now_ + static_cast<Utime>(1e6 * seconds);
    const Utime begin = now_;
    for (; now_ < end; now_ += wheel_period) {
      MotionSample sample;
      sample.utime = now_;
      sample.T_odom_robot = planar_pose(0.5e-6 * static_cast<double>(now_ - begin), 0, 0);
      sample.covariance = 1e-6 * Matrix6d::Identity();
      odometry_t message = to_message(sample, "wheels");
      set_origin(message, Origin{seq_++, sender});
      bus_.deliver("ODOMETRY", message);
      if (now_ % frame_period == 0) look(now_ - wheel_period);
    }
  }
  void look(Utime utime) {
    FeatureFrame frame;
    frame.utime = utime;
    frame.width = 640, frame.height = 480;
    frame.fx = frame.fy = 525;
    frame.has_mount = true;
    features_t message = to_message(frame);
    set_origin(message, Origin{seq_++, 9});
    bus_.deliver("FEATURES", message);
  }

  testing::TestBus bus_;
  FastSlamNode& node_ = bus_.add<FastSlamNode>(ConfigNode::parse("{particles: 20}"));
  Utime now_ = 10'000'000;
  std::int64_t seq_ = 0;
};

TEST_F(DarkDrive, WhoFollowsTheLocalPoseSeesNoLeapWhereTheWorldBeginsAnew) {
  drive(5, 1);
  drive(2, 2);
  const auto local = bus_.on<pose_estimate_t>("FASTSLAM_LOCAL_POSE");
  ASSERT_GT(local.size(), 60U);
  double way = 0;
  for (std::size_t i = 1; i < local.size(); ++i) {
    const double step = distance_between(from_message(local[i - 1].T_map_robot, "pose"),
                                         from_message(local[i].T_map_robot, "pose"));
    EXPECT_LT(step, 0.2) << i;
    way += step;
  }
  EXPECT_GT(way, 3) << "it drives all the time";
}

/// Speeds up while nothing is heard of its odometry for a second, of which all comes at once then.
class StalledDrive : public ::testing::Test {
 protected:
  static constexpr Utime begin = 10'000'000, end = 15'000'000, stalls = 12'000'000, goes_on = 13'000'000;
  static constexpr Utime frame_period = 100'000, wheel_period = 20'000, latency = 20'000;

  static double way(Utime utime) {
    const double seconds = 1e-6 * static_cast<double>(utime - begin);
    const double faster = std::clamp(seconds - 2, 0.0, 1.0);
    return 0.1 * seconds + 0.2 * faster * faster + 0.4 * std::max(0.0, seconds - 3);
  }
  void drive(int beacons) {
    std::vector<odometry_t> late;
    for (Utime now = begin; now <= end; now += wheel_period) {
      if (now > begin && (now - latency) % frame_period == 0) look(now - latency, beacons);
      late.push_back(wheels(now));
      if (now > stalls && now < goes_on) continue;
      for (const odometry_t& message : late) bus_.deliver("ODOMETRY", message);
      late.clear();
    }
  }
  odometry_t wheels(Utime utime) {
    MotionSample sample;
    sample.utime = utime;
    sample.T_odom_robot = planar_pose(way(utime), 0, 0);
    sample.covariance = 1e-11 * static_cast<double>(utime - begin) * Matrix6d::Identity();
    odometry_t message = to_message(sample, "wheels");
    set_origin(message, Origin{seq_++, 1});
    return message;
  }
  void look(Utime utime, int beacons) {
    FeatureFrame frame;
    frame.utime = utime;
    frame.width = 640, frame.height = 480;
    frame.fx = frame.fy = 525, frame.cx = 320, frame.cy = 240;
    frame.has_mount = true;
    const Eigen::Isometry3d T_world_camera = planar_pose(way(utime), 0, 0) * frame.T_robot_camera;
    for (int i = 0; i < beacons; ++i) {
      const Eigen::Vector3d beacon(4 + 0.1 * (i % 5), -1 + 2.0 * i / beacons, -0.6 + 0.4 * (i % 4));
      Feature feature;
      feature.kind = MeasurementKind::point;
      feature.landmark_id = i;
      feature.point = (T_world_camera.inverse() * beacon).cast<float>();
      feature.x = static_cast<float>(frame.cx + frame.fx * feature.point.x() / feature.point.z());
      feature.y = static_cast<float>(frame.cy + frame.fy * feature.point.y() / feature.point.z());
      feature.depth_sigma = 0.01F;
      frame.features.push_back(feature);
    }
    features_t message = to_message(frame);
    set_origin(message, Origin{seq_++, 9});
    bus_.deliver("FEATURES", message);
  }
  double error(const pose_estimate_t& pose) const { return pose.T_map_robot.trans[0] - way(pose.utime); }

  testing::TestBus bus_;
  FastSlamNode& node_ = bus_.add<FastSlamNode>(ConfigNode::parse("{particles: 100}"));
  std::int64_t seq_ = 0;
};

TEST_F(StalledDrive, InTheDarkOdometryThatComesLateLosesNoWay) {
  drive(0);
  const auto local = bus_.on<pose_estimate_t>("FASTSLAM_LOCAL_POSE");
  ASSERT_GT(local.size(), 45U);
  double guessed = 0;
  for (const pose_estimate_t& pose : local) {
    guessed = std::min(guessed, error(pose));
    if (pose.utime >= goes_on) {
      EXPECT_NEAR(error(pose), 0, 0.03) << pose.utime;
    }
  }
  EXPECT_LT(guessed, -0.05) << "it is a stall";
}

TEST_F(StalledDrive, AGuessIsToldToBeOne) {
  drive(0);
  double guessed = 0;
  for (const pose_estimate_t& pose : bus_.on<pose_estimate_t>("FASTSLAM_LOCAL_POSE")) {
    if (pose.utime <= stalls) {
      EXPECT_LT(pose.covariance[0], 1e-3);
    }
    if (pose.utime < goes_on) guessed = std::sqrt(pose.covariance[0]);
  }
  EXPECT_GT(guessed, 0.03);
}

TEST_F(StalledDrive, WhatLandmarksHavePutRightIsNotPutRightTwice) {
  drive(20);
  const auto poses = bus_.on<pose_estimate_t>("FASTSLAM_POSE");
  ASSERT_GT(poses.size(), 45U);
  for (const pose_estimate_t& pose : poses) EXPECT_NEAR(error(pose), 0, 0.01) << pose.utime;
}

}  // namespace
}  // namespace lcmslam
