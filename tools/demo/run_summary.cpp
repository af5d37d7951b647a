#include "tools/demo/run_summary.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/evaluation/trajectory_plot.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/runtime/version.hpp>

namespace lcmslam {
namespace {

struct NamedPath {
  const char* name;
  const RecordedPath& path;
  const char* frame;  // in which its poses are given
};

std::vector<NamedPath> paths(const RunRecorder& run) {
  return {
      {"odometry", run.odometry(), "odom"}, {"fastslam", run.fastslam(), "map"}, {"icp", run.icp(), "map"}};
}

const status_t& status_of(const RunRecorder& run, const std::string& process) {
  static const status_t none = [] {
    status_t s;
    s.state = 0;
    s.cpu_total = s.latency_p50 = s.latency_p95 = 0;
    s.memory = 0;
    return s;
  }();
  const auto found = run.board().find(process);
  return found == run.board().end() ? none : found->second;
}

Table path_table(const RunRecorder& run) {
  Table table({"path", "poses", "matched", "ATE rmse m", "median", "max", "RPE m/s", "RPE deg/s",
               "vs odometry", "lost", "degraded"});
  double odometry_ate = 0;
  for (const auto& [name, path, frame] : paths(run)) {
    std::vector<std::string> row = {name, std::to_string(path.trajectory.size())};
    if (const auto report = run.evaluate_path(path)) {
      const double ate = report->absolute.translation.rmse;
      if (&path == &run.odometry()) odometry_ate = ate;
      row.insert(row.end(), {std::to_string(report->matched_poses), fixed_number(ate, 4),
                             fixed_number(report->absolute.translation.median, 4),
                             fixed_number(report->absolute.translation.maximum, 4),
                             fixed_number(report->per_second.translation.rmse, 4),
                             fixed_number(report->per_second.rotation.rmse * 180 / M_PI, 2),
                             fixed_number(ate / odometry_ate, 2)});
    } else {
      row.resize(9, "-");
    }
    row.insert(row.end(), {std::to_string(path.lost), std::to_string(path.degraded)});
    table.add(row);
  }
  return table;
}

/// How the processes kept up with the channel that drives them.
Table load_table(const RunRecorder& run) {
  Table table({"process", "channel", "received", "lost on the bus", "skipped for time", "malformed", "p50 ms",
               "p95 ms", "CPU s", "MB"});
  for (const auto& [process, channel] :
       {std::pair("surf", "CAMERA"), std::pair("icp", "CAMERA"), std::pair("odometry", "FEATURES"),
        std::pair("odometry", "ENCODERS"), std::pair("fastslam", "FEATURES")}) {
    const status_t& status = status_of(run, process);
    const ChannelLoss loss = channel_loss(status, channel);
    if (loss.received == 0) continue;
    const auto skipped = loss.queue_drops + static_cast<std::int64_t>(status_value(status, "skipped"));
    table.add({process, channel, std::to_string(loss.received), std::to_string(loss.lost),
               std::to_string(skipped), std::to_string(loss.decode_errors),
               fixed_number(1e3 * status.latency_p50, 0), fixed_number(1e3 * status.latency_p95, 0),
               fixed_number(status.cpu_total, 1), fixed_number(static_cast<double>(status.memory) / 1e6, 0)});
  }
  return table;
}

nlohmann::json error_json(const PoseErrors& errors) {
  return {{"translation_rmse_m", errors.translation.rmse},
          {"translation_median_m", errors.translation.median},
          {"translation_max_m", errors.translation.maximum},
          {"rotation_rmse_rad", errors.rotation.rmse},
          {"pairs", errors.translation.count}};
}

nlohmann::json path_json(const RecordedPath& path, const std::optional<TrajectoryReport>& report,
                         const std::string& problem) {
  nlohmann::json json = {{"poses", path.trajectory.size()},
                         {"lost", path.lost},
                         {"degraded", path.degraded},
                         {"restarts", path.restarts}};
  if (path.every > 1) json["kept_every"] = path.every;
  if (!problem.empty()) json["truth_problem"] = problem;
  if (report) {
    json["matched"] = report->matched_poses;
    json["tracked_fraction"] = report->tracked_fraction;
    json["ate"] = error_json(report->absolute);
    json["rpe_per_second"] = error_json(report->per_second);
    json["rpe_per_metre"] = error_json(report->per_metre);
  }
  return json;
}

nlohmann::json process_json(const status_t& status) {
  nlohmann::json json = {{"cpu_s", status.cpu_total},           {"memory_bytes", status.memory},
                         {"kernel_drops", status.kernel_drops}, {"receive_buffer", status.receive_buffer},
                         {"latency_p50_s", status.latency_p50}, {"latency_p95_s", status.latency_p95}};
  for (const auto& in : status.inputs) {
    const ChannelLoss loss = channel_loss(status, in.channel);  // over all senders
    json["inputs"][in.channel] = {{"received", loss.received},       {"lost", loss.lost},
                                  {"duplicates", loss.duplicates},   {"reordered", loss.reordered},
                                  {"queue_drops", loss.queue_drops}, {"decode_errors", loss.decode_errors}};
  }
  for (const auto& out : status.outputs)
    json["outputs"][out.channel] = {{"sent", out.sent}, {"largest_bytes", out.largest}};
  for (const auto& value : status.values) json["values"][value.name] = value.value;
  return json;
}

double frames(const RunRecorder& run, const RunFacts& facts) {
  return facts.frames >= 0 ? facts.frames : status_value(status_of(run, "camera"), "frames");
}

nlohmann::json versions_json() {
  return {{"lcmslam", lcmslam_version},
          {"opencv", CV_VERSION},
          {"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"compiler", __VERSION__}};
}

/// The member as camera_calibration_t has them; null when none came.
nlohmann::json calibration_json(const RunRecorder& run) {
  if (!run.calibration_message()) return nullptr;
  const std::vector<std::uint8_t> bytes = encode_message(*run.calibration_message());
  const MessageType* type = MessageType::find(static_cast<std::uint64_t>(camera_calibration_t::getHash()));
  return nlohmann::json::parse(
      message_json(read_message(*type, bytes.data(), bytes.size(), MessageLimits::none())));
}

void save_path(const std::filesystem::path& folder, const std::string& name, const Trajectory& trajectory,
               const std::string& frame, bool kitti) {
  save_tum(folder / (name + ".txt"), trajectory, {frame, "robot"});
  if (kitti) save_kitti(folder / (name + "_kitti.txt"), trajectory);
}

/// What the table of errors does not say by itself.
std::string notes_of_paths(const RunRecorder& run) {
  std::string text;
  if (const std::string problem = run.truth_problem(); !problem.empty()) text += problem + "\n";
  for (const auto& [name, path, frame] : paths(run)) {
    std::string problem;
    run.evaluate_path(path, &problem);
    if (!problem.empty()) text += fmt::format("{} was not compared with the truth: {}\n", name, problem);
  }
  for (const auto& [name, path, frame] : paths(run))
    if (path.restarts > 0)
      text += fmt::format("{} began again {} time{}: poses and errors are of its newest map\n", name,
                          path.restarts, path.restarts == 1 ? "" : "s");
  return text;
}

}  // namespace

std::string format_errors(const RunRecorder& run) {
  if (run.truth().empty()) return run.truth_problem().empty() ? "" : run.truth_problem() + "\n";
  return path_table(run).text() + notes_of_paths(run);
}

std::string format_summary(const RunRecorder& run, const RunFacts& facts) {
  const auto odometry = run.evaluate_path(run.odometry());
  std::string text = fmt::format("\n{}\n", facts.title);
  text += fmt::format("{:.0f} frames in {:.1f} s", frames(run, facts), facts.seconds);
  if (odometry) text += fmt::format(", path {:.1f} m", odometry->truth_length);
  text += "\n\n" + path_table(run).text() + "\n" + notes_of_paths(run);
  text += load_table(run).text() + "\n";
  text += fmt::format("landmarks {:.0f}, keyframes {:.0f}, points in keyframes {:.0f}\n",
                      status_value(status_of(run, "map-server"), "landmarks"),
                      status_value(status_of(run, "map-server"), "keyframes"),
                      status_value(status_of(run, "map-server"), "map_points"));
  if (const double bad = status_value(status_of(run, "camera"), "malformed_frames"); bad > 0)
    text += fmt::format("{:.0f} frames were malformed or missing and skipped\n", bad);
  if (const double slowed = status_value(status_of(run, "camera"), "slowed_seconds"); slowed > 0.05)
    text += fmt::format("the source fell {:.1f} s behind and was slowed down\n", slowed);
  if (const double leaps = status_value(status_of(run, "camera"), "leaps_of_time"); leaps > 0)
    text += fmt::format("the recording's stamps leap {:.0f} times\n", leaps);
  for (const auto& event : facts.events) text += event + "\n";
  return text;
}

void write_run_files(const std::filesystem::path& folder, const RunRecorder& run, const RunFacts& facts) {
  nlohmann::json json = {{"version", lcmslam_version},
                         {"title", facts.title},
                         {"versions", versions_json()},
                         {"config", facts.config},
                         {"configuration", nlohmann::json::parse(facts.configuration)},
                         {"overrides", facts.overrides},
                         {"calibration", calibration_json(run)},
                         {"timing", {{"wall_seconds", facts.seconds}}},
                         {"frames", frames(run, facts)},
                         {"alignment", "se3"},
                         {"association", "truth interpolated at the estimate's stamps"},
                         {"events", facts.events}};
  if (!facts.key.empty()) json["key"] = facts.key;
  if (const std::string problem = run.truth_problem(); !problem.empty()) json["truth_problem"] = problem;
  const Trajectory truth = run.truth();
  std::vector<PlottedPath> plotted;
  if (!truth.empty()) {
    save_path(folder, "truth", truth, "world", facts.kitti);
    plotted.push_back(top_view("truth", plot_colour(0), truth));
  }
  std::size_t colour = 1;
  for (const auto& [name, path, frame] : paths(run)) {
    std::string problem;
    const auto report = run.evaluate_path(path, &problem);
    json["paths"][name] = path_json(path, report, problem);
    Trajectory trajectory = path.trajectory;
    sort_trajectory(trajectory);
    save_path(folder, name, trajectory, frame, facts.kitti);
    Trajectory shown = report ? Trajectory() : trajectory;
    if (report)
      for (const MatchedPose& match : report->matches) shown.push_back({match.utime, match.T_world_estimate});
    plotted.push_back(top_view(name, plot_colour(colour++), shown));
  }
  for (const auto& [process, status] : run.board()) json["processes"][process] = process_json(status);
  if (run.reply())
    json["map"] = nlohmann::json::parse(run.reply()->data.begin(), run.reply()->data.end(), nullptr, false);

  PlotSettings plot;
  plot.title = facts.title;
  write_png(folder / "trajectories.png", plot_paths(plotted, plot));
  // The last of all: whoever finds it finds the rest.
  write_atomically(FilePlace(folder / "summary.json"),
                   json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace lcmslam
