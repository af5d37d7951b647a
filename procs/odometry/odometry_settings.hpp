#pragma once
#include <lcmslam/odometry/source_choice.hpp>
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

/// As `source` names them.
constexpr Choice<OdometrySource> odometry_sources[] = {{"wheels", OdometrySource::wheels},
                                                       {"twist", OdometrySource::twist},
                                                       {"external", OdometrySource::external},
                                                       {"visual", OdometrySource::visual}};

/// The channel that a source comes on; of another driver's pose the settings name it.
inline std::string odometry_channel(OdometrySource source, const std::string& external_channel) {
  switch (source) {
    case OdometrySource::wheels:
      return "ENCODERS";
    case OdometrySource::twist:
      return "TWIST";
    case OdometrySource::visual:
      return "FEATURES";
    default:
      return external_channel;
  }
}

/// Section `odometry`.
struct OdometryNodeSettings {
  std::string source = "auto";
  double auto_wait = 2;
  std::string external_channel = "POSE_BODY";
  double clock_offset = 0;
  int frame_queue = 4;
  std::uint64_t seed = 1;
  WheelOdometrySettings wheels;
  TwistOdometrySettings twist;
  VisualOdometrySettings visual;
  PathNoiseSettings noise;

  void describe(SettingsVisitor& s) {
    s.choice("source", source, {"auto", "wheels", "twist", "visual", "external"},
             "from ENCODERS, TWIST, FEATURES or another driver's pose; auto: the first of wheels, twist, "
             "external and "
             "visual that is there");
    s.number("auto_wait", auto_wait, "s", {0, 60},
             "of message time that auto waits for a better source than has come (wheels are taken at once)");
    s.text("external_channel", external_channel, "of another driver's bot_core.pose_t");
    s.number("clock_offset", clock_offset, "s", {-10, 10},
             "added to the stamps of wheels, twists and foreign poses gives the camera's clock; lcmslam "
             "doctor --log "
             "and --drive measure it");
    describe_frame_queue(s, frame_queue);
    s.number("seed", seed, "", {0, 2147483647}, "of visual odometry's RANSAC");
    s.section("wheels", wheels, "how wrong wheel encoders are");
    s.section("twist", twist, "how wrong velocities are");
    s.section("visual", visual, "frame to keyframe alignment of features");
    s.section("noise", noise, "added to the path, to see how much of it the mappers take away");
  }
};

}  // namespace lcmslam
