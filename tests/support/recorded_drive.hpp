#pragma once
// logs/kitchen_drive.lcmlog for tests of whole processes: 26 s of the simulated kitchen, three frames a
// second. The robot rests for 2 s, drives a bend of 180 degrees and comes by its own way again after 22 s. An
// estimate that stands still, or that only follows the wheels, shows in a share of what odometry errs by in
// the same run.

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/encoders_t.hpp>
#include <lcmslam/evaluation/trajectory_error.hpp>
#include <lcmslam/features_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/ground_truth_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam::testing {

/// Of the odometry process: Gaussian noise in each of 30 steps a second (thesis, figure 2.10), so that
/// following the wheels is far from the truth even on a short way.
constexpr const char* noisy_odometry = "{noise: {mode: random_walk, sigma: 0.02, seed: 3}}";

class RecordedDrive {
 public:
  static constexpr double moves = 2, turns = 8, turned = 16, revisits = 22, ends = 26;  // s after the start

  /// The same for every caller.
  static RecordedDrive& instance() {
    static RecordedDrive drive;
    return drive;
  }

  using Message = std::pair<std::string, std::vector<std::uint8_t>>;
  using Messages = std::vector<Message>;

  struct Part {
    double from = moves, to = ends;  ///< s
    bool with_features =
        false;                 ///< those of one SurfNode, made once; else a SurfNode of the bus may make them
    double features_late = 0;  ///< s behind their image
    std::pair<double, double> covered = {0, 0};  ///< s from, to: frames without features
    std::function<void(camera_calibration_t&)> change_calibration = [](camera_calibration_t&) {};
    /// What is delivered in the place of a message (its channel and bytes) of a time, s.
    std::function<Messages(const Message&, double seconds)> disturb = [](const Message& m, double) {
      return Messages{m};
    };
  };

  /// Events of the part in their order.
  void play(TestBus& bus, const Part& part) {
    camera_calibration_t calibration = calibration_;
    part.change_calibration(calibration);
    bus.deliver("CAMERA_CALIBRATION", calibration);
    std::multimap<Utime, const features_t*> waiting;
    const auto deliver = [&](Utime utime, const Message& message) {
      for (const auto& [channel, bytes] : part.disturb(message, seconds_of(utime)))
        bus.deliver(channel, bytes);
    };
    for (const Event& event : events_) {
      if (event.utime < at(part.from) || event.utime > at(part.to)) continue;
      while (!waiting.empty() && waiting.begin()->first < event.utime) {
        deliver(waiting.begin()->first, {"FEATURES", encode_message(*waiting.begin()->second)});
        waiting.erase(waiting.begin());
      }
      deliver(event.utime, {event.channel, event.bytes});
      if (part.with_features && event.channel == "CAMERA") {
        const features_t& frame = features().at(event.utime);
        const bool dark = event.utime >= at(part.covered.first) && event.utime < at(part.covered.second);
        waiting.emplace(event.utime + static_cast<Utime>(1e6 * part.features_late),
                        dark ? &emptied(frame) : &frame);
      }
    }
    for (const auto& [utime, message] : waiting) deliver(utime, {"FEATURES", encode_message(*message)});
  }

  /// The drive's start.
  Utime start() const { return truth_.front().utime; }
  /// Of the robot, interpolated.
  Eigen::Isometry3d truth_at(Utime utime) const {
    const auto after = std::lower_bound(truth_.begin() + 1, truth_.end() - 1, utime,
                                        [](const StampedPose& pose, Utime t) { return pose.utime < t; });
    const auto before = after - 1;
    const double fraction =
        static_cast<double>(utime - before->utime) / static_cast<double>(after->utime - before->utime);
    return interpolate(before->T_world_body, after->T_world_body, fraction);
  }

  /// m, RMS of the positions after they have been laid onto the truth (ATE).
  double error_of(const Trajectory& path) const {
    EvaluationSettings settings;
    settings.association = Association::interpolate_truth;
    return evaluate(truth_, path, settings).absolute.translation.rmse;
  }
  double error_of(const std::vector<pose_estimate_t>& poses) const {
    Trajectory path;
    for (const auto& m : poses) path.push_back({m.utime, from_message(m.T_map_robot, "T_map_robot")});
    return error_of(path);
  }
  double error_of(const std::vector<odometry_t>& samples) const {
    Trajectory path;
    for (const auto& m : samples) path.push_back({m.utime, from_message(m.T_odom_robot, "T_odom_robot")});
    return error_of(path);
  }
  /// The same of the robot's poses at the nodes of a graph.
  double error_of(const graph_t& graph) const {
    const Eigen::Isometry3d T_camera_robot =
        from_message(calibration_.T_robot_camera, "T_robot_camera").inverse();
    Trajectory path;
    for (const auto& node : graph.nodes)
      path.push_back({node.keyframe_utime, from_message(node.T_map_camera, "T_map_camera") * T_camera_robot});
    return error_of(path);
  }
  /// What an estimate on `channel` errs by as a share of what odometry does.
  double share_of_odometry(const TestBus& bus, const std::string& channel) const {
    return error_of(bus.on<pose_estimate_t>(channel)) / error_of(bus.on<odometry_t>("ODOMETRY"));
  }

 private:
  struct Event {
    Utime utime;
    std::string channel;
    std::vector<std::uint8_t> bytes;
  };

  RecordedDrive() {
    LogReader log(own_log("kitchen_drive.lcmlog"));
    bool has_calibration = false;
    while (const auto event = log.next()) {
      const auto* data = event->data.data();
      if (event->channel == "GROUND_TRUTH") {
        const auto m = decode_message<ground_truth_t>(data, event->data.size());
        truth_.push_back({m.utime, from_message(m.T_frame_child, "T_frame_child")});
      } else if (event->channel == "CAMERA_CALIBRATION") {
        if (!has_calibration) calibration_ = decode_message<camera_calibration_t>(data, event->data.size());
        has_calibration = true;
      } else {
        events_.push_back({event->timestamp, event->channel, event->data});
      }
    }
  }

  double seconds_of(Utime utime) const { return 1e-6 * static_cast<double>(utime - truth_.front().utime); }
  Utime at(double seconds) const { return truth_.front().utime + static_cast<Utime>(1e6 * seconds); }

  const std::map<Utime, features_t>& features() {
    if (!features_.empty()) return features_;
    TestBus bus;
    bus.add<OdometryNode>();
    bus.add<SurfNode>(ConfigNode::parse("{max_features: 600}"), 500);
    Part everything;
    everything.from = 0;
    play(bus, everything);
    for (const features_t& m : bus.on<features_t>("FEATURES")) features_[m.utime] = m;
    return features_;
  }

  const features_t& emptied(const features_t& frame) {
    features_t& empty = emptied_[frame.utime];
    empty = frame;
    empty.features.clear();
    empty.n_features = 0;
    return empty;
  }

  camera_calibration_t calibration_;
  std::vector<Event> events_;
  Trajectory truth_;
  std::map<Utime, features_t> features_, emptied_;
};

}  // namespace lcmslam::testing
