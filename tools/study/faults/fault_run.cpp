#include "tools/study/faults/fault_run.hpp"

#include <atomic>
#include <csignal>
#include <map>
#include <optional>
#include <thread>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/features_t.hpp>
#include <lcmslam/graph_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/odometry_t.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/status_reporter.hpp>
#include "tools/launch/graph.hpp"
#include "tools/launch/status_table.hpp"
#include "tools/study/faults/disturbed_source.hpp"
#include "tools/study/faults/kept_share.hpp"
#include "tools/study/faults/small_disk.hpp"
#include "tools/study/faults/stranger.hpp"

namespace lcmslam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double limit = 0.15;          // m off is no tracking
constexpr double camera_restart = 0.5;  // s until a camera's next process has its first image
constexpr std::chrono::seconds longest_start{60}, longest_export{20}, last_frames{3};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Takes all processors, twice over, as long as it lives.
class BusyProcessors {
 public:
  BusyProcessors() {
    for (unsigned i = 0; i < 2 * std::max(1u, std::thread::hardware_concurrency()); ++i)
      threads_.emplace_back([this] {
        while (!stop_) continue;
      });
  }
  ~BusyProcessors() {
    stop_ = true;
    for (std::thread& thread : threads_) thread.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

class FaultRun {
 public:
  FaultRun(CameraSource& source, const FaultRunSettings& settings)
      : settings_(settings),
        bus_(settings.lcm_url),
        publisher_(bus_.lcm(), draw_sender(), largest_whole_message(settings.lcm_url)),
        other_(bus_.lcm(), draw_sender(), largest_whole_message(settings.lcm_url)),
        stranger_(bus_.lcm(), settings.seed),
        camera_(make_publisher()),
        source_(source, *camera_, other_) {
    subscribe();
    receiver_.emplace(bus_, inputs_);
  }

  FaultRunResult run() {
    start_graph();
    start_ = Clock::now();
    while (step(seconds_since(start_))) listen(std::chrono::milliseconds(5));
    end_fault();
    const Clock::time_point end = Clock::now();
    while (Clock::now() - end < last_frames) listen(std::chrono::milliseconds(20));
    export_maps("final");
    const Clock::time_point stop = Clock::now();
    for (const std::string& event : supervisor_.stop()) result_.events.push_back(event);
    result_.stop_seconds = seconds_since(stop);
    hear_out(*receiver_);
    judge();
    return result_;
  }

 private:
  void subscribe() {
    for (const auto& [channel, watch] : {std::pair("FASTSLAM_POSE", &fastslam_), {"ICP_POSE", &icp_}})
      inputs_.subscribe<pose_estimate_t>(
          channel, 10000, [this, channel = std::string(channel), watch = watch](const auto& m) {
            watch->add(m, elapsed_);
            hear_pose(channel, m.detail);
          });
    inputs_.subscribe<status_t>("STATUS", 1000, [this](const auto& m) { hear(m); });
    told_.listen(inputs_);
    inputs_.subscribe<map_reply_t>("MAP_REPLY", 100, [this](const auto& m) { replied_ = m.request_id; });
    stranger_.listen<features_t>(inputs_, "FEATURES");
    stranger_.listen<odometry_t>(inputs_, "ODOMETRY");
    stranger_.listen<landmarks_t>(inputs_, "FASTSLAM_LANDMARKS");
    stranger_.listen<keyframe_t>(inputs_, "ICP_KEYFRAME");
    stranger_.listen<graph_t>(inputs_, "ICP_GRAPH");
  }

  void start_graph() {
    GraphOptions options{settings_.config, settings_.lcm_url, "info", settings_.overrides, settings_.folder};
    options.overrides.push_back("map-server.folder=" + settings_.folder.string());
    for (const ProcessSpec& spec : read_graph(options).processes)
      if (spec.name != "camera") supervisor_.start(spec);
    const Clock::time_point begin = Clock::now();
    while (board_.size() < supervisor_.processes().size()) {
      listen(std::chrono::milliseconds(50));
      if (Clock::now() - begin > longest_start || supervisor_.refused())
        throw std::runtime_error("the graph did not start; see " + (settings_.folder / "logs").string());
    }
  }

  void listen(Clock::duration wait) {
    if (!exporting_) elapsed_ = seconds_since(start_);
    Arrival arrival;
    if (receiver_->take(arrival, wait)) arrival.deliver();
    for (const std::string& event : supervisor_.poll()) {
      result_.events.push_back(event);
      result_.record.alarms.push_back({elapsed_, event});
    }
  }

  void hear(const status_t& status) {
    const auto before = board_.find(status.process);
    if (before != board_.end())
      if (const std::string trouble = trouble_told(before->second, status); !trouble.empty())
        result_.record.alarms.push_back({elapsed_, trouble});
    board_[status.process] = status;
    if (just_started(status)) source_.calibrate();
  }

  /// What a pose says in words, say that the wheels slipped.
  void hear_pose(const std::string& channel, const std::string& detail) {
    std::string& before = pose_words_[channel];
    const bool usual = detail.rfind("degenerate", 0) == 0;  // before a bare wall
    if (!detail.empty() && !usual && detail != before)
      result_.record.alarms.push_back({elapsed_, channel + ": " + detail});
    before = detail;
  }

  /// False at the end of the recording.
  bool step(double elapsed) {
    note_memory(elapsed);
    if (active_ && elapsed > active_->at + active_->seconds) end_fault();
    if (!active_ && next_fault_ < settings_.faults.size() && elapsed > settings_.faults[next_fault_].at)
      begin_fault(settings_.faults[next_fault_++]);
    if (active_ && elapsed >= next_message_) {
      if (active_->kind == FaultKind::stranger) stranger_.pretend();
      if (active_->kind == FaultKind::garbage) stranger_.babble();
      if (ballast_) ballast_->fill();
      next_message_ = elapsed + 0.05;
    }
    return source_.publish_until(elapsed, active_ ? &*active_ : nullptr);
  }

  void note_memory(double elapsed) {
    const auto note = [elapsed](std::vector<double>& minutes, double bytes) {
      minutes.resize(static_cast<std::size_t>(elapsed / 60) + 1);
      minutes.back() = std::max(minutes.back(), bytes);
    };
    double all = 0;
    for (const auto& [name, status] : board_) {
      const auto bytes = static_cast<double>(status.memory);
      note(result_.memory_of[name], bytes);
      all += bytes;
    }
    note(result_.memory, all);
  }

  void begin_fault(const Fault& fault) {
    if (settings_.export_before) {  // the drive stands still meanwhile
      const Clock::time_point begin = Clock::now();
      exporting_ = true;
      export_maps("before-" + std::to_string(next_fault_));
      exporting_ = false;
      start_ += Clock::now() - begin;
    }
    active_ = fault;
    source_.begin(fault);
    if (fault.kind == FaultKind::killed && fault.process == "camera")
      kill_camera();
    else if (fault.kind == FaultKind::killed)
      signal_process(SIGKILL);
    if (fault.kind == FaultKind::paused) signal_process(SIGSTOP);
    if (fault.kind == FaultKind::disk_full) ballast_.emplace(settings_.folder, map_file());
    if (fault.kind == FaultKind::busy) busy_.emplace();
  }

  void end_fault() {
    if (!active_) return;
    if (active_->kind == FaultKind::paused) signal_process(SIGCONT);
    ballast_.reset();
    busy_.reset();
    active_.reset();
  }

  std::filesystem::path map_file() const { return settings_.folder / "map.lcmslam"; }

  std::unique_ptr<LcmPublisher> make_publisher() {
    return std::make_unique<LcmPublisher>(bus_.lcm(), draw_sender(),
                                          largest_whole_message(settings_.lcm_url));
  }

  void kill_camera() {
    auto next = make_publisher();
    source_.restart(*next, camera_restart);
    camera_ = std::move(next);
  }

  void signal_process(int signal) {
    for (const Supervisor::State& state : supervisor_.processes())
      if (state.spec.name == active_->process && state.pid > 0) kill(state.pid, signal);
  }

  /// Into a folder of the run's; the graph goes on meanwhile.
  void export_maps(const std::string& name) {
    map_request_t request{};
    request.request_id = ++requests_;
    request.kind = map_request_t::EXPORT;
    request.argument = name;
    request.format = "pcd";
    publisher_.publish("MAP_REQUEST", request);
    const Clock::time_point begin = Clock::now();
    while (replied_ != requests_ && Clock::now() - begin < longest_export)
      listen(std::chrono::milliseconds(5));
  }

  void judge() {
    const Utime undisturbed = source_.begun().value_or(0) + static_cast<Utime>(1e6 * settings_.laid_until);
    const Trajectory truth = source_.truth();
    result_.record.fastslam = fastslam_.held(truth, undisturbed);
    result_.record.icp = icp_.held(truth, undisturbed);
    result_.begun = source_.begun().value_or(0);
    result_.map = judge_kept_map(map_file(), told_, truth, source_.T_robot_camera());
    for (const auto& [watch, outcome, map] : {std::tuple(&fastslam_, &result_.fastslam, "fastslam_map.pcd"),
                                              std::tuple(&icp_, &result_.icp, "icp_map.pcd")}) {
      outcome->ate = watch->ate(truth);
      outcome->poses = watch->poses();
      outcome->sessions = watch->sessions();
      outcome->false_tracking = watch->longest_false_tracking(truth, undisturbed, limit);
      for (std::size_t i = 0; i < settings_.faults.size(); ++i) {
        const std::filesystem::path before = settings_.folder / ("before-" + std::to_string(i + 1)) / map;
        const auto kept = kept_share(before, settings_.folder / "final", map);
        if (!kept) continue;
        ++outcome->maps_before;
        if (*kept >= outcome->kept) continue;
        outcome->kept = *kept;
        outcome->lost_after =
            to_string(settings_.faults[i].kind) + std::string(" ") + settings_.faults[i].process;
      }
    }
  }

  FaultRunSettings settings_;
  LcmBus bus_;
  LcmPublisher publisher_, other_;
  Stranger stranger_;
  std::unique_ptr<LcmPublisher> camera_;
  DisturbedSource source_;
  Inputs inputs_;
  std::optional<Receiver> receiver_;
  Supervisor supervisor_;
  StatusBoard board_;
  std::map<std::string, std::string> pose_words_;  // by channel, the last ones
  ToldMaps told_;
  MapperWatch fastslam_, icp_;
  FaultRunResult result_;
  std::optional<Fault> active_;
  std::optional<BusyProcessors> busy_;
  std::optional<Ballast> ballast_;
  std::size_t next_fault_ = 0;
  double next_message_ = 0, elapsed_ = 0;  // s
  Clock::time_point start_ = Clock::now();
  bool exporting_ = false;
  std::int64_t requests_ = 0, replied_ = 0;
};

}  // namespace

FaultRunResult run_with_faults(CameraSource& source, const FaultRunSettings& settings) {
  return FaultRun(source, settings).run();
}

}  // namespace lcmslam
