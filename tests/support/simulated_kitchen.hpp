#pragma once
// The first seconds of the simulated kitchen as messages, rendered once for all tests of a program.

#include <map>
#include <string>
#include <vector>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam::testing {

inline SimulationSettings kitchen_settings(const std::string& base = "differential", std::uint64_t seed = 1) {
  SimulationSettings settings;
  settings.scene = source_folder() / "config/scenes/kitchen.yaml";
  settings.base = base;
  settings.seed = seed;
  return settings;
}

class SimulatedKitchen {
 public:
  /// The same for every caller.
  static SimulatedKitchen& instance() {
    static SimulatedKitchen kitchen;
    return kitchen;
  }

  const Simulation& simulation() const { return simulation_; }
  /// m from the true position of each pose, in the map frame that the first one makes.
  std::vector<double> position_errors(const std::vector<pose_estimate_t>& poses) const {
    std::vector<double> errors;
    Eigen::Isometry3d T_world_map;
    for (const pose_estimate_t& m : poses) {
      const Eigen::Isometry3d T_map_robot = from_message(m.T_map_robot, "T_map_robot");
      const Eigen::Isometry3d T_world_robot = simulation_.T_world_robot(m.utime);
      if (errors.empty()) T_world_map = T_world_robot * T_map_robot.inverse();
      errors.push_back((T_world_robot.inverse() * T_world_map * T_map_robot).translation().norm());
    }
    return errors;
  }
  camera_calibration_t calibration() const {
    camera_calibration_t message = to_message(simulation_.calibration());
    message.seq = 0;
    message.sender = 1000;
    return message;
  }
  /// The k-th frame, at 10 Hz.
  const images_t& frame(int k) {
    const auto found = frames_.find(k);
    if (found != frames_.end()) return found->second;
    EncodedFrame encoded = encode(simulation_.render(frame_time(k)));
    encoded.sensor = simulation_.calibration().sensor;
    images_t message = to_message(encoded);
    set_origin(message, {k, 1000});
    return frames_[k] = message;
  }
  Utime frame_time(int k) const { return simulation_.start() + 100'000 * (k + 1); }

  /// Plays the first frames with the encoders between them, up to 40 ms after the last.
  void play(TestBus& bus, int frames, const std::string& base = "differential") {
    const Simulation other(kitchen_settings(base));
    bus.deliver("CAMERA_CALIBRATION", calibration());
    std::int64_t seq = 0;
    for (Utime t = simulation_.start(); t <= frame_time(frames - 1) + 40'000; t += 20'000) {
      encoders_t encoders = to_message(other.encoders(t));
      set_origin(encoders, {seq++, 1001});
      bus.deliver("ENCODERS", encoders);
      const Utime since = t - simulation_.start();
      const int k = static_cast<int>(since / 100'000) - 1;
      if (since % 100'000 == 0 && k >= 0 && k < frames) bus.deliver("CAMERA", frame(k));
    }
  }

 private:
  SimulatedKitchen() : simulation_(kitchen_settings()) {}
  Simulation simulation_;
  std::map<int, images_t> frames_;
};

}  // namespace lcmslam::testing
