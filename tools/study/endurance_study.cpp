#include "tools/study/endurance_study.hpp"

#include <chrono>
#include <cmath>
#include <map>

#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/machine.hpp>
#include "procs/camera/camera_source.hpp"
#include "procs/camera/publish_event.hpp"
#include "tools/batch/batch_graph.hpp"
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

/// How far a mapper's poses are from the truth, in the world that its first one makes.
class PathError {
 public:
  void add(const StampedPose& pose) { waiting_.push_back(pose); }

  /// Takes those that the truth reaches by now.
  void compare(const Trajectory& truth) {
    std::size_t done = 0;
    for (; done < waiting_.size() && waiting_[done].utime <= truth.back().utime; ++done) {
      const auto T_world_robot = pose_at(truth, waiting_[done].utime);
      if (!T_world_robot) continue;
      const Eigen::Isometry3d& T_map_robot = waiting_[done].T_world_body;
      if (!T_world_map_) T_world_map_ = *T_world_robot * T_map_robot.inverse();
      squares_ += (*T_world_map_ * T_map_robot.translation() - T_world_robot->translation()).squaredNorm();
      ++count_;
    }
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(done));
  }

  /// Since it was last asked, m; NaN without poses.
  double take_rms() {
    const double rms = std::sqrt(squares_ / static_cast<double>(count_));
    squares_ = 0;
    count_ = 0;
    return rms;
  }

 private:
  std::vector<StampedPose> waiting_;
  std::optional<Eigen::Isometry3d> T_world_map_;
  double squares_ = 0;
  std::int64_t count_ = 0;
};

/// What has been spent and said since the beginning.
struct Totals {
  double process = 0, rendering = 0;    // CPU s
  std::map<std::string, double> nodes;  // CPU s of their handlers
  std::map<std::string, double> bytes;  // by channel
};

/// Of the channels that begin so.
double bytes_on(const Totals& totals, const std::string& beginning) {
  double sum = 0;
  for (const auto& [channel, bytes] : totals.bytes)
    if (channel.rfind(beginning, 0) == 0) sum += bytes;
  return sum;
}

class Endurance : private Publisher {
 public:
  explicit Endurance(const EnduranceSettings& settings)
      : Publisher(1000),
        settings_(settings),
        source_(make_live_simulation({settings.simulation, settings.jpeg_quality, "live"})),
        config_(configuration(settings)),
        graph_(config_, {"surf", "odometry", "fastslam", "icp", "map-server"}, 1,
               [this](const BatchMessage& m) { take(m); }) {
    config_.ignore("launch");
    config_.finish();
  }

  EnduranceResult run() {
    const OneThread one_thread;
    const auto frames = static_cast<std::int64_t>(source_->frames());
    const auto laps = static_cast<std::int64_t>(settings_.simulation.laps);
    publish("CAMERA_CALIBRATION", to_message(source_->calibration()));
    before_ = totals();
    for (std::int64_t frame = 0; const auto event = next();) {
      if (const auto* truth = std::get_if<GroundTruth>(&*event)) {
        add_truth({truth->utime, truth->T_world_child});
        continue;
      }
      publish_event(*this, *event);
      frame += std::holds_alternative<EncodedFrame>(*event) ? 1 : 0;
      const auto lap = static_cast<std::int64_t>(result_.laps.size());
      if (lap < laps && frame * laps >= (lap + 1) * frames)
        end_lap(frame - frames_before_, event_utime(*event));
    }
    const Clock::time_point stop = Clock::now();
    graph_.finish();
    result_.stop_seconds = std::chrono::duration<double>(Clock::now() - stop).count();
    return std::move(result_);
  }

 private:
  static ConfigNode configuration(const EnduranceSettings& settings) {
    ConfigNode config = settings.config;
    config.set("map-server.folder", yaml_quoted(std::filesystem::absolute(settings.folder).string()));
    config.set("map-server.snapshot_period", "0");  // by the wall's clock, which is not the drive's
    return config;
  }

  std::optional<CameraEvent> next() {
    const double begin = thread_cpu_seconds();
    auto event = source_->next();
    rendering_ += thread_cpu_seconds() - begin;
    return event;
  }

  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override {
    graph_.deliver({channel, bytes, utime});
  }

  void take(const BatchMessage& message) {
    bytes_[message.channel] += static_cast<double>(message.bytes.size());
    if (message.channel != "FASTSLAM_POSE" && message.channel != "ICP_POSE") return;
    const auto pose = decode_message<pose_estimate_t>(message.bytes.data(), message.bytes.size());
    PathError& error = message.channel == "ICP_POSE" ? icp_ : fastslam_;
    error.add({pose.utime, from_message(pose.T_map_robot, "T_map_robot")});
  }

  void add_truth(const StampedPose& pose) {
    constexpr std::size_t longest = 2000;  // poses, 40 s: no pose comes later
    truth_.push_back(pose);
    fastslam_.compare(truth_);
    icp_.compare(truth_);
    if (truth_.size() >= 2 * longest)
      truth_.erase(truth_.begin(), truth_.end() - static_cast<std::ptrdiff_t>(longest));
  }

  Totals totals() const {
    Totals now{process_cpu_seconds(), rendering_, {}, bytes_};
    for (const auto& node : graph_.summary()) now.nodes[node.process] = node.cpu_seconds;
    return now;
  }

  void end_lap(std::int64_t frames, Utime utime) {
    const Totals now = totals();
    LapFigures lap;
    lap.frames = frames;
    lap.seconds = 1e-6 * static_cast<double>(utime - begun_);
    const auto per_frame = [&](double cpu) { return 1e3 * cpu / static_cast<double>(frames); };
    double handlers = 0;
    for (const auto& [node, figure] : std::map<std::string, double*>{{"surf", &lap.surf},
                                                                     {"odometry", &lap.odometry},
                                                                     {"fastslam", &lap.fastslam},
                                                                     {"icp", &lap.icp},
                                                                     {"map-server", &lap.map_server}}) {
      *figure = per_frame(now.nodes.at(node) - before_.nodes[node]);
      handlers += *figure;
    }
    lap.all = per_frame(now.process - before_.process - (now.rendering - before_.rendering));
    lap.beside = lap.all - handlers;
    for (const auto& [beginning, figure] :
         std::map<std::string, double*>{{"", &lap.traffic},
                                        {"FASTSLAM_", &lap.fastslam_traffic},
                                        {"ICP_", &lap.icp_traffic},
                                        {"ICP_GRAPH", &lap.graph_traffic}})
      *figure = 1e-3 * (bytes_on(now, beginning) - bytes_on(before_, beginning)) / lap.seconds;
    for (const auto& node : graph_.summary()) note_values(node, lap);
    lap.resident = 1e-6 * static_cast<double>(resident_bytes());
    lap.fastslam_error = fastslam_.take_rms();
    lap.icp_error = icp_.take_rms();
    result_.laps.push_back(lap);
    if (settings_.after_lap) settings_.after_lap(lap);
    before_ = totals();
    frames_before_ += frames;
    begun_ = utime;
  }

  static void note_values(const BatchGraph::Summary& node, LapFigures& lap) {
    const std::map<std::string, double> values(node.report.values.begin(), node.report.values.end());
    if (node.process == "fastslam") lap.landmarks = values.at("landmarks");
    if (node.process != "icp") return;
    lap.icp_memory = values.at("memory_mb");
    lap.keyframes = values.at("keyframes");
    lap.graph_nodes = values.at("graph_nodes");
    lap.graph_edges = values.at("graph_edges");
  }

  const EnduranceSettings& settings_;
  std::unique_ptr<CameraSource> source_;
  std::map<std::string, double> bytes_;
  PathError fastslam_, icp_;
  Trajectory truth_;
  ConfigNode config_;
  BatchGraph graph_;
  EnduranceResult result_;
  Totals before_;  // at the lap's beginning
  double rendering_ = 0;
  std::int64_t frames_before_ = 0;
  Utime begun_ = 1'000'000;  // when the simulation begins
};

}  // namespace

EnduranceResult study_endurance(const EnduranceSettings& settings) {
  return Endurance(settings).run();
}

}  // namespace lcmslam
