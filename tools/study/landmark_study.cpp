#include "tools/study/landmark_study.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/batch/batch_graph.hpp"
#include "tools/evaluate/pose_log.hpp"
#include "tools/import/landmark_log.hpp"
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

/// Hands messages on to the graph that takes them.
class GraphPublisher : public Publisher {
 public:
  explicit GraphPublisher(BatchGraph& graph) : Publisher(100), graph_(graph) {}

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) override {
    if (graph_.is_input(channel)) graph_.deliver({channel, bytes, utime});
  }
  BatchGraph& graph_;
};

nlohmann::json errors_json(const ErrorStatistics& e) {
  return {{"rmse_m", e.rmse}, {"median_m", e.median}, {"max_m", e.maximum}, {"poses", e.count}};
}

std::vector<double> column(const LandmarkStudyResult& result, double (*value)(const LandmarkScore&)) {
  std::vector<double> values;
  for (const LandmarkScore& s : result.scores)
    if (s.restarts == 0 && std::isfinite(value(s))) values.push_back(value(s));
  return values;
}

double (*const columns[])(const LandmarkScore&) = {
    [](const LandmarkScore& s) { return s.online.rmse; },
    [](const LandmarkScore& s) { return s.online.maximum; },
    [](const LandmarkScore& s) { return s.smoothed.rmse; },
    [](const LandmarkScore& s) { return s.smoothed.maximum; },
    [](const LandmarkScore& s) { return s.landmarks; },
    [](const LandmarkScore& s) { return s.consistency ? s.consistency->nees.mean : std::nan(""); },
    [](const LandmarkScore& s) { return s.consistency ? 100 * (1 - s.consistency->inside) : std::nan(""); },
};

}  // namespace

LandmarkRun run_landmarks(const LandmarkRecording& recording, const ConfigNode& file, int seed) {
  ConfigNode config = file;
  config.set("fastslam.seed", std::to_string(seed));
  LandmarkRun run;
  PoseLog paths;
  std::vector<std::string> processes = {"fastslam"};
  if (!recording.twists.empty()) processes.insert(processes.begin(), "odometry");
  BatchGraph graph(config, processes, 1, [&](const BatchMessage& m) {
    paths.add(m.channel, m.bytes.data(), m.bytes.size());
    if (m.channel != "FASTSLAM_LANDMARKS") return;
    const auto tile = decode_message<landmarks_t>(m.bytes.data(), m.bytes.size());
    for (const std::int64_t id : tile.removed) run.landmarks.erase(id);
    for (const landmark_t& l : tile.landmarks) run.landmarks[l.id] = {l.mean[0], l.mean[1], l.mean[2]};
  });
  GraphPublisher publisher(graph);
  publish_landmarks(recording, publisher);
  graph.finish();
  paths.finish();
  const auto summary = graph.summary();
  for (const auto& [name, value] : summary.back().report.values) run.report[name] = value;
  const auto path = [&](const std::string& name) {
    const auto found = paths.channels().find(name);
    return found == paths.channels().end() ? Trajectory() : found->second.trajectory;
  };
  run.online = path("FASTSLAM_POSE");
  run.smoothed = path("FASTSLAM_SMOOTHED");
  if (!run.online.empty()) run.restarts = paths.channels().at("FASTSLAM_POSE").restarts;
  return run;
}

LandmarkScore score(const LandmarkRecording& recording, const Trajectory& reference, const LandmarkRun& run,
                    int seed) {
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  settings.alignment = Alignment::se2;
  LandmarkScore result;
  result.seed = seed;
  result.report = run.report;
  result.restarts = run.restarts;
  result.landmarks = std::nan("");
  result.online = result.smoothed = statistics({});
  if (result.restarts > 0 && run.online.size() < 3)
    return result;  // a map that was begun just before the end
  const TrajectoryReport online = evaluate(reference, run.online, settings);
  result.online = online.absolute.translation;
  result.consistency = online.consistency;
  double worst = -1;
  for (const MatchedPose& m : online.matches) {
    const double error = (m.T_world_truth.translation() - m.T_world_estimate.translation()).norm();
    if (error <= worst) continue;
    worst = error;
    result.worst_at = 1e-6 * static_cast<double>(m.utime - reference.front().utime);
  }
  if (run.smoothed.size() < 3) return result;
  const TrajectoryReport smoothed = evaluate(reference, run.smoothed, settings);
  result.smoothed = smoothed.absolute.translation;
  double squares = 0;
  result.existing = recording.landmark_truth.size();
  for (const auto& [id, truth] : recording.landmark_truth) {
    const auto landmark = run.landmarks.find(id);
    if (landmark == run.landmarks.end()) continue;
    const Eigen::Vector3d mean = smoothed.alignment.T_truth_estimate * landmark->second;
    squares += (mean.head<2>() - truth).squaredNorm();
    ++result.found;
  }
  if (result.found > 0) result.landmarks = std::sqrt(squares / static_cast<double>(result.found));
  return result;
}

LandmarkStudyResult study_landmarks(const LandmarkRecording& recording, const ConfigNode& config,
                                    const std::vector<int>& seeds) {
  LandmarkStudyResult result;
  if (recording.truth.empty()) result.batch = solve_batch(recording);
  const Trajectory& reference = result.batch ? result.batch->path : recording.truth;
  for (const int seed : seeds)
    result.scores.push_back(score(recording, reference, run_landmarks(recording, config, seed), seed));
  return result;
}

std::string landmark_table(const LandmarkStudyResult& result) {
  Table table({"seed", "online RMSE m", "max", "at s", "smoothed RMSE m", "max", "landmarks RMSE m",
               "NEES (3)", "beyond 95 % bound, %", "landmarks found", "new maps"});
  std::size_t broken = 0;
  for (const LandmarkScore& s : result.scores) {
    std::vector<std::string> row = {std::to_string(s.seed)};
    for (const auto value : columns) row.push_back(fixed_number(value(s), 3));
    row.insert(row.begin() + 3, fixed_number(s.worst_at, 0));
    row.push_back(s.existing > 0 ? fmt::format("{} of {}", s.found, s.existing) : "-");
    row.push_back(std::to_string(s.restarts));
    broken += s.restarts > 0 ? 1 : 0;
    table.add(row);
  }
  for (const bool worst : {false, true}) {
    std::vector<std::string> row = {worst ? "worst" : "median"};
    for (const auto value : columns) {
      const std::vector<double> values = column(result, value);
      row.push_back(
          values.empty()
              ? "-"
              : fixed_number(worst ? *std::max_element(values.begin(), values.end()) : median(values), 3));
    }
    row.insert(row.begin() + 3, "");
    row.insert(row.end(), 2, "");
    table.add(row);
  }
  const std::string text = table.text() + new_maps_text(broken, result.scores.size());
  if (!result.batch) return text;
  const BatchSolution& b = *result.batch;
  return fmt::format(
             "no truth: against the batch solution ({}, cost {:.1f} of {} residuals; RMS odometry {:.3f}, "
             "landmarks {:.3f} sigma)\n\n",
             b.converged ? "converged" : "NOT CONVERGED", b.cost, b.residuals, b.odometry_rms,
             b.landmark_rms) +
         text;
}

nlohmann::json landmark_json(const LandmarkStudyResult& result) {
  nlohmann::json json = {{"runs", nlohmann::json::array()}};
  if (const auto& b = result.batch)
    json["batch_solution"] = {{"converged", b->converged},
                              {"cost", b->cost},
                              {"residuals", b->residuals},
                              {"odometry_rms_sigma", b->odometry_rms},
                              {"landmark_rms_sigma", b->landmark_rms}};
  for (const LandmarkScore& s : result.scores) {
    json["runs"].push_back({{"seed", s.seed},
                            {"online", errors_json(s.online)},
                            {"worst_at_s", s.worst_at},
                            {"smoothed", errors_json(s.smoothed)},
                            {"restarts", s.restarts},
                            {"report", s.report}});
    if (std::isfinite(s.landmarks)) json["runs"].back()["landmarks_rmse_m"] = s.landmarks;
    if (s.existing > 0)
      json["runs"].back().update({{"landmarks_found", s.found}, {"landmarks_existing", s.existing}});
  }
  return json;
}

}  // namespace lcmslam
