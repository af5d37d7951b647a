#pragma once
#include <lcmslam/odometry/twist_odometry.hpp>
#include <lcmslam/odometry/visual_odometry.hpp>
#include <lcmslam/odometry/wheel_odometry.hpp>
#include <lcmslam/runtime/node_settings.hpp>

namespace lcmslam {

/// Thesis, figure 2.10: Gaussian noise on the path, to see how much of it the mappers take away.
struct PathNoiseSettings {
  std::string mode = "none";
  double sigma = 0.02;
  double rate = 10;
  std::uint64_t seed = 1;

  void describe(SettingsVisitor& s) {
    s.choice("mode", mode, {"none", "random_walk", "white"},
             "each draw adds to the offset from the path, or is the offset");
    s.number("sigma", sigma, "m", {0, 10}, "of a draw on x and y of the odometry's frame");
    s.number("rate", rate, "Hz", {0.01, 1000}, "of the draws, in message time");
    s.number("seed", seed, "", {0, 2147483647}, "of the draws");
  }
};

/// Section `odometry`.
struct OdometryNodeSettings {
  std::string source = "wheels";
  std::string external_channel = "POSE_BODY";
  int frame_queue = 4;
  std::uint64_t seed = 1;
  WheelOdometrySettings wheels;
  TwistOdometrySettings twist;
  VisualOdometrySettings visual;
  PathNoiseSettings noise;

  void describe(SettingsVisitor& s) {
    s.choice("source", source, {"wheels", "twist", "visual", "external"},
             "from ENCODERS, TWIST, FEATURES, or another driver's pose");
    s.text("external_channel", external_channel, "of another driver's bot_core.pose_t");
    describe_frame_queue(s, frame_queue);
    s.number("seed", seed, "", {0, 2147483647}, "of visual odometry's RANSAC");
    s.section("wheels", wheels, "how wrong wheel encoders are");
    s.section("twist", twist, "how wrong velocities are");
    s.section("visual", visual, "frame to keyframe alignment of features");
    s.section("noise", noise, "added to the path, to see how much of it the mappers take away");
  }
};

}  // namespace lcmslam
