#pragma once
// A wheeled robot with an inclined sensor head that drives through a scene: what its cameras and
// wheel encoders measure, and where it truly is. A source of data like a recording.
//
// Same settings, same bytes: every reading is a function of (settings, time), whatever the order of
// calls and the number of threads. In a drive of more than three laps on wheels that do not drive sideways,
// all but the first and the last are alike, and what cameras see in one is rendered once.

#include <filesystem>
#include <memory>
#include <string>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/odometry/encoders.hpp>
#include <lcmslam/settings/settings.hpp>
#include <lcmslam/simulation/camera_faults.hpp>

namespace lcmslam {

struct SimulationSettings {
  std::filesystem::path scene;
  std::string head = "tof";
  std::string base = "differential";
  std::uint64_t seed = 1;
  double seconds = 0;
  double frame_rate = 0;
  int laps = 1;
  int threads = 1;
  std::uint64_t unit = 0;
  CameraFaults faults = {};  // written so that a scene alone may be given in braces

  void describe(SettingsVisitor& s) {
    s.required_path("scene", scene, "a file of config/scenes, relative to the file that names it");
    s.text("head", head,
           "which cameras the robot has: tof, rgbd, or one of config/heads by its name or its file's path");
    s.number("unit", unit, "", {0, 2147483647},
             "which piece of that head: focal lengths, mount and clock are off by what a careful calibration "
             "leaves, and a time-of-flight camera errs as much at other ranges; 0: just as told");
    s.choice("base", base, {"differential", "steered", "mecanum"}, "which wheels the robot has");
    s.number("seed", seed, "", {0, 2147483647},
             "of the sensors' errors; the scene and the path do not depend on it");
    s.number("seconds", seconds, "s", {0, 1e6}, "of the path; 0: the whole of it");
    s.number("frame_rate", frame_rate, "Hz", {0, 200},
             "of the images; 0: the head's own, 10 for tof and 30 for rgbd");
    s.number("laps", laps, "", {1, 1000},
             "in which the path is driven, in a scene with a way back to its start");
    s.number("threads", threads, "", {1, 64}, "that render one image");
    s.section("faults", faults, "what real cameras do besides; what is 0 is as the head's file has it");
  }
};

/// The file of config/heads that the settings name, beside the folder of the scene; empty for pinned heads.
std::filesystem::path head_file(const SimulationSettings& settings);

class Simulation {
 public:
  /// Throws ConfigError for a bad scene, std::invalid_argument for a bad setting.
  explicit Simulation(const SimulationSettings& settings);
  ~Simulation();

  /// Intrinsics, T_colour_depth and mount as the robot is told. Depth is not registered to colour with either
  /// head.
  const RgbdCalibration& calibration() const;
  /// As they are: the same for unit 0.
  const RgbdCalibration& true_calibration() const;

  Utime start() const;  ///< 1 s
  Utime end() const;
  double frame_rate() const;   ///< Hz
  Utime frame_period() const;  ///< us
  double path_length() const;  ///< m, seen from above

  /// Exact truth. The world frame is the scene's; the path begins anywhere in it. Clamped to start..end
  /// of the path.
  Eigen::Isometry3d T_world_robot(Utime utime) const;

  /// The newest reading at or before `utime` (a multiple of 20 ms after start()).
  const Encoders& encoders(Utime utime) const;

  /// One shot with the colour exposure's middle at `utime`, stamped with the settings' faults and the
  /// piece's. depth_utime is up to 15 ms off, and the depth is that of the robot's pose then. `amplitude` is
  /// empty for the rgbd head.
  RgbdFrame render(Utime utime) const;

  /// Metres from a point in the world to the nearest surface of the scene.
  double distance_to_surface(const Eigen::Vector3d& point_world) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace lcmslam
