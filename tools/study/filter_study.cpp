#include "tools/study/filter_study.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/evaluation/table.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include "procs/odometry/odometry_settings.hpp"
#include "tools/evaluate/pose_log.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/study/measures.hpp"

namespace lcmslam {
namespace {

constexpr double near_view = 0.6, near_turn = 0.5;  // m, rad: views that may show the same features
constexpr double same_thing = 0.05;                 // m, by the true poses
constexpr std::size_t fewest_poses = 3;             // that an alignment does not fit whatever they are
const double nothing = std::nan("");

/// Nothing of a map that was begun just before the end.
double ate(const Trajectory& truth, const Trajectory& path, TrajectoryReport* report = nullptr) {
  if (path.size() < fewest_poses) return nothing;
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  const TrajectoryReport found = evaluate(truth, path, settings);
  if (report != nullptr) *report = found;
  return found.absolute.translation.rmse;
}

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return nothing;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
}

Eigen::Vector3d place(const Eigen::Isometry3d& T_world_robot, const FeatureFrame& frame, int feature) {
  return T_world_robot * frame.T_robot_camera *
         frame.features[static_cast<std::size_t>(feature)].point.cast<double>();
}

// The frame of the first third whose view is most like that of `late`; nothing when none is near.
const FeatureFrame* earlier_view(const std::vector<FeatureFrame>& frames, const FeatureFrame& late,
                                 const Trajectory& truth) {
  const auto T_late = pose_at(truth, late.utime);
  const FeatureFrame* best = nullptr;
  double least = 1;
  for (std::size_t i = 0; T_late && i < frames.size() / 3; ++i) {
    const auto T_early = pose_at(truth, frames[i].utime);
    if (!T_early) continue;
    const Eigen::Isometry3d between =
        (*T_early * frames[i].T_robot_camera).inverse() * (*T_late * late.T_robot_camera);
    const double unlike =
        std::max(between.translation().norm() / near_view, rotation_angle(between) / near_turn);
    if (unlike >= least) continue;
    least = unlike;
    best = &frames[i];
  }
  return best;
}

// Where the first pose says where the map lies: what a covariance seen from there speaks of.
EvaluationSettings at_first_pose() {
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  settings.alignment = Alignment::first_pose;
  return settings;
}

/// Of points with covariances those that lie on a surface to three of their sigmas along its normal, which is
/// the distance's gradient. What lies on no surface in sight (a corner that two things make in the image) has
/// none that would say anything.
class ShareInside {
 public:
  explicit ShareInside(const SurfaceDistance& surface) : surface_(surface) {}

  /// In the truth's world, m and m^2.
  void add(const Eigen::Vector3d& place, const Eigen::Matrix3d& covariance) {
    constexpr double step = 1e-3, farthest = 0.2;  // m
    const double distance = surface_(place);
    if (distance > farthest) return;
    Eigen::Vector3d normal;
    for (int i = 0; i < 3; ++i)
      normal(i) = surface_(place + step * Eigen::Vector3d::Unit(i)) -
                  surface_(place - step * Eigen::Vector3d::Unit(i));
    const Eigen::Vector3d along = normal.normalized();
    inside_ += distance * distance < 9 * along.dot(covariance * along);
    ++all_;
  }
  double share() const { return all_ > 0 ? static_cast<double>(inside_) / all_ : nothing; }

 private:
  const SurfaceDistance& surface_;
  int inside_ = 0, all_ = 0;
};

double landmarks_inside(const std::vector<FilterRun::Landmark>& landmarks,
                        const Eigen::Isometry3d& T_truth_map, const SurfaceDistance& surface) {
  const Eigen::Matrix3d R = T_truth_map.linear();
  ShareInside share(surface);
  for (const FilterRun::Landmark& landmark : landmarks)
    share.add(T_truth_map * landmark.mean, R * landmark.covariance * R.transpose());
  return share.share();
}

}  // namespace

double features_inside(const std::vector<FeatureFrame>& frames, const Trajectory& truth,
                       const SurfaceDistance& surface) {
  ShareInside share(surface);
  for (const FeatureFrame& frame : frames) {
    const auto T_world_robot = pose_at(truth, frame.utime);
    if (!T_world_robot) continue;
    const Eigen::Isometry3d T = *T_world_robot * frame.T_robot_camera;
    for (const Feature& f : frame.features)
      if (f.kind == MeasurementKind::point)
        share.add(T * f.point.cast<double>(),
                  T.linear() * point_covariance(f, frame) * T.linear().transpose());
  }
  return share.share();
}

namespace {

std::string cell(double value, int decimals) {
  return fixed_number(value, decimals);
}

struct ColumnOf {
  const char* name;
  double (*value)(const FilterScore&);
  bool more_is_better = false;
};
const ColumnOf columns[] = {
    {"odometry ATE m", [](const FilterScore& s) { return s.odometry; }},
    {"fastslam ATE m", [](const FilterScore& s) { return s.fastslam; }},
    {"smoothed", [](const FilterScore& s) { return s.smoothed; }},
    {"ratio", [](const FilterScore& s) { return s.fastslam / s.odometry; }},
    {"noise taken away", [](const FilterScore& s) { return s.corrected; }, true},
    {"landmarks off surface m", [](const FilterScore& s) { return s.landmarks; }},
    {"p90", [](const FilterScore& s) { return s.landmarks_p90; }},
    {"first to last m", [](const FilterScore& s) { return s.reunion; }},
    {"by odometry", [](const FilterScore& s) { return s.odometry_reunion; }},
    {"within 3 sigma", [](const FilterScore& s) { return s.landmarks_inside; }, true},
    {"features within 3 sigma", [](const FilterScore& s) { return s.features_inside; }, true},
    {"NEES", [](const FilterScore& s) { return s.nees; }},
    {"beyond 95 % bound", [](const FilterScore& s) { return s.beyond; }},
};

}  // namespace

PreparedLog prepare_log(const std::string& log, const ConfigNode& config, int threads) {
  PreparedLog result;
  ConfigNode quiet = config;
  quiet.set("odometry.noise.mode", "none");  // what is added belongs to a run
  // Odometry moves depth from its own stamp to colour's, as in the whole graph.
  BatchGraph graph(quiet, {"surf", "odometry"}, threads, [&](const BatchMessage& m) {
    if (m.channel != "FEATURES") return;
    result.messages.push_back(m);
    result.frames.push_back(from_message(decode_message<features_t>(m.bytes.data(), m.bytes.size())));
  });
  PoseLog poses;
  MessageReader reader(log);
  while (const auto event = reader.next()) {
    BatchMessage message{std::string(event->channel), {}, event->timestamp};
    message.bytes.assign(event->data, event->data + event->size);
    if (message.channel == "GROUND_TRUTH")
      poses.add(message.channel, message.bytes.data(), message.bytes.size());
    else if (message.channel == "CAMERA")
      graph.deliver(std::move(message));
    else if (message.channel == "ENCODERS" || message.channel == "TWIST" ||
             message.channel == "CAMERA_CALIBRATION") {  // which tells the filter how long rows are read
      graph.deliver(message);
      result.messages.push_back(std::move(message));
    }
  }
  graph.finish();
  poses.finish();
  if (result.frames.empty()) throw std::runtime_error(log + ": has no images (lcmslam log info)");
  const PoseChannel& truth = poses.channel("GROUND_TRUTH", log);
  result.truth = truth.trajectory;
  if (truth.body == "camera")
    result.truth = in_other_frame(truth.trajectory, result.frames.front().T_robot_camera.inverse());
  return result;
}

FilterRun run_filter(const PreparedLog& log, const ConfigNode& file, int seed) {
  ConfigNode config = file;
  config.set("fastslam.seed", std::to_string(seed));
  config.set("odometry.seed", std::to_string(seed));
  config.set("odometry.noise.seed", std::to_string(seed));
  PoseLog poses;
  std::map<std::int64_t, FilterRun::Landmark> landmarks;
  BatchGraph graph(config, {"odometry", "fastslam"}, 1, [&](const BatchMessage& m) {
    poses.add(m.channel, m.bytes.data(), m.bytes.size());
    if (m.channel != "FASTSLAM_LANDMARKS") return;
    const auto tile = decode_message<landmarks_t>(m.bytes.data(), m.bytes.size());
    for (const std::int64_t id : tile.removed) landmarks.erase(id);
    for (const Landmark& l : landmarks_of(tile)) landmarks[l.id] = {l.mean, l.covariance};
  });
  for (const BatchMessage& message : log.messages) graph.deliver(message);
  graph.finish();
  poses.finish();
  FilterRun run;
  const auto path = [&](const std::string& name) {
    const auto found = poses.channels().find(name);
    return found == poses.channels().end() ? Trajectory() : found->second.trajectory;
  };
  run.odometry = path("ODOMETRY");
  run.fastslam = path("FASTSLAM_POSE");
  run.smoothed = path("FASTSLAM_SMOOTHED");
  if (!run.fastslam.empty()) {
    const PoseChannel& told = poses.channels().at("FASTSLAM_POSE");
    run.lost = told.lost + told.earlier_lost;
    run.restarts = told.restarts;
  }
  for (const auto& [id, landmark] : landmarks) run.landmarks.push_back(landmark);
  return run;
}

std::vector<double> reunion_distances(const std::vector<FeatureFrame>& frames, const Trajectory& truth,
                                      const Trajectory& path) {
  std::vector<double> distances;
  Matcher matcher;
  for (std::size_t i = frames.size() * 9 / 10; i < frames.size(); ++i) {
    const FeatureFrame& late = frames[i];
    const FeatureFrame* early = earlier_view(frames, late, truth);
    if (early == nullptr) continue;
    const auto T_early = pose_at(path, early->utime), T_late = pose_at(path, late.utime);
    if (!T_early || !T_late) continue;
    const Eigen::Isometry3d true_early = *pose_at(truth, early->utime),
                            true_late = *pose_at(truth, late.utime);
    for (const Match& m : matcher.match(early->features, late.features)) {
      const double apart = (place(true_early, *early, m.a) - place(true_late, late, m.b)).norm();
      if (!(apart < same_thing)) continue;  // a wrong match, or no depth
      distances.push_back((place(*T_early, *early, m.a) - place(*T_late, late, m.b)).norm());
    }
  }
  return distances;
}

FilterScore score_filter(const PreparedLog& log, const FilterRun& run, double clean,
                         const SurfaceDistance& surface) {
  FilterScore score;
  TrajectoryReport report;
  score.fastslam = ate(log.truth, run.fastslam, &report);
  score.nees = report.consistency ? report.consistency->nees.mean : nothing;
  score.beyond = report.consistency ? 1 - report.consistency->inside : nothing;
  score.odometry = ate(log.truth, run.odometry);
  score.smoothed = ate(log.truth, run.smoothed);
  score.clean = clean;
  score.corrected = (score.odometry - score.fastslam) / (score.odometry - clean);
  const bool aligned = std::isfinite(score.fastslam);
  std::vector<double> off;
  for (const FilterRun::Landmark& landmark : run.landmarks)
    if (surface && aligned) off.push_back(surface(report.alignment.T_truth_estimate * landmark.mean));
  score.landmarks = median(off);
  score.landmarks_p90 = quantile(off, 0.9);
  const std::vector<double> reunions = reunion_distances(log.frames, log.truth, run.fastslam);
  score.reunions = static_cast<int>(reunions.size());
  score.reunion = median(reunions);
  score.odometry_reunion = median(reunion_distances(log.frames, log.truth, run.odometry));
  score.lost = run.lost;
  score.restarts = run.restarts;
  score.landmarks_inside = nothing;
  if (surface && aligned) {
    const TrajectoryReport anchored = evaluate(log.truth, run.fastslam, at_first_pose());
    score.landmarks_inside = landmarks_inside(run.landmarks, anchored.alignment.T_truth_estimate, surface);
  }
  score.features_inside = surface ? features_inside(log.frames, log.truth, surface) : nothing;
  return score;
}

std::vector<FilterScore> study_filter(const std::vector<std::string>& logs, const ConfigNode& config,
                                      const std::vector<int>& seeds, const SurfaceDistance& surface) {
  const std::string mode = read_settings<OdometryNodeSettings>(config.section("odometry")).noise.mode;
  const auto with_noise = [&](const std::string& wanted) {
    ConfigNode changed = config;
    changed.set("odometry.noise.mode", wanted);  // copies share what is set: set it before each run
    return changed;
  };
  std::vector<FilterScore> scores;
  for (const std::string& name : logs) {
    const PreparedLog log = prepare_log(name, config, 2);
    for (const int seed : seeds) {
      const double clean =
          mode == "none" ? nothing : ate(log.truth, run_filter(log, with_noise("none"), seed).odometry);
      const FilterRun run = run_filter(log, with_noise(mode), seed);
      scores.push_back(score_filter(log, run, clean, surface));
      scores.back().log = std::filesystem::path(name).stem();
      scores.back().seed = seed;
    }
  }
  return scores;
}

std::string filter_table(const std::vector<FilterScore>& scores) {
  std::vector<std::string> header = {"log", "seed"};
  for (const ColumnOf& column : columns) header.emplace_back(column.name);
  header.insert(header.end(), {"pairs", "lost", "new maps"});
  Table table(header);
  int lost = 0, restarts = 0;
  std::size_t broken = 0;
  for (const FilterScore& s : scores) {
    std::vector<std::string> row = {s.log, std::to_string(s.seed)};
    for (const ColumnOf& column : columns) row.push_back(cell(column.value(s), 4));
    row.insert(row.end(), {std::to_string(s.reunions), std::to_string(s.lost), std::to_string(s.restarts)});
    table.add(row);
    lost = std::max(lost, s.lost);
    restarts = std::max(restarts, s.restarts);
    broken += s.restarts > 0 ? 1 : 0;
  }
  for (const bool worst : {false, true}) {
    std::vector<std::string> row = {worst ? "worst" : "median", ""};
    for (const ColumnOf& column : columns) {
      std::vector<double> values;
      for (const FilterScore& s : scores)
        if (s.restarts == 0 && std::isfinite(column.value(s))) values.push_back(column.value(s));
      row.push_back(cell(!worst                  ? median(values)
                         : column.more_is_better ? quantile(values, 0)
                                                 : quantile(values, 1),
                         4));
    }
    row.insert(row.end(), {"", worst ? std::to_string(lost) : "", worst ? std::to_string(restarts) : ""});
    table.add(row);
  }
  return table.text() + new_maps_text(broken, scores.size());
}

nlohmann::json filter_json(const std::vector<FilterScore>& scores) {
  nlohmann::json json = {{"runs", nlohmann::json::array()}};
  for (const FilterScore& s : scores) {
    nlohmann::json run = {{"log", s.log},
                          {"seed", s.seed},
                          {"reunion_pairs", s.reunions},
                          {"lost", s.lost},
                          {"restarts", s.restarts}};
    for (const ColumnOf& column : columns)
      if (std::isfinite(column.value(s))) run[column.name] = column.value(s);
    json["runs"].push_back(run);
  }
  return json;
}

}  // namespace lcmslam
