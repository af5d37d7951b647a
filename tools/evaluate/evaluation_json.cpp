// All figures of an evaluation, in SI units.

#include <nlohmann/json.hpp>

#include <lcmslam/runtime/version.hpp>
#include "tools/evaluate/evaluation_report.hpp"

namespace lcmslam {
namespace {

nlohmann::json statistics_json(const ErrorStatistics& s, const std::string& unit) {
  return {{"rmse_" + unit, s.rmse},
          {"mean_" + unit, s.mean},
          {"median_" + unit, s.median},
          {"max_" + unit, s.maximum},
          {"pairs", s.count}};
}

nlohmann::json errors_json(const PoseErrors& errors) {
  return {{"translation", statistics_json(errors.translation, "m")},
          {"rotation", statistics_json(errors.rotation, "rad")}};
}

nlohmann::json report_json(const TrajectoryReport& r) {
  const Eigen::Vector3d t = r.alignment.T_truth_estimate.translation();
  const Eigen::Quaterniond q(r.alignment.T_truth_estimate.linear());
  nlohmann::json json = {{"matched_poses", r.matched_poses},
                         {"tracked_fraction", r.tracked_fraction},
                         {"truth_length_m", r.truth_length},
                         {"alignment",
                          {{"scale", r.alignment.scale},
                           {"translation_m", {t.x(), t.y(), t.z()}},
                           {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}}},
                         {"ate", errors_json(r.absolute)},
                         {"rpe_per_frame", errors_json(r.per_frame)},
                         {"rpe_per_second", errors_json(r.per_second)},
                         {"rpe_per_metre", errors_json(r.per_metre)}};
  if (r.consistency)
    json["consistency"] = {{"components", r.consistency->components},
                           {"poses", r.consistency->nees.count},
                           {"nees_mean", r.consistency->nees.mean},
                           {"nees_median", r.consistency->nees.median},
                           {"poses_within_95", r.consistency->inside},
                           {"positions_within_95", r.consistency->position_inside},
                           {"error_over_sigma", r.consistency->error_over_sigma}};
  return json;
}

nlohmann::json path_json(const EvaluatedPath& path) {
  nlohmann::json json = {{"file", path.file}, {"poses", path.trajectory.size()}};
  if (!path.channel.empty()) json["channel"] = path.channel;
  if (!path.body.empty()) json["frame"] = path.body;
  return json;
}

nlohmann::json body_json(const BodyOffset& offset, bool aligned) {
  const Eigen::Vector3d t = offset.T_estimate_truth.translation();
  const Eigen::Quaterniond q(offset.T_estimate_truth.linear());
  return {{"aligned", aligned},
          {"rotated", offset.rotated},
          {"displaced", offset.displaced},
          {"angle_rad", offset.rotated ? offset.angle : 0.0},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

nlohmann::json estimate_json(const EvaluatedEstimate& e) {
  nlohmann::json json = path_json(e.path);
  json["name"] = e.path.name;
  json["lost"] = e.path.lost;
  json["degraded"] = e.path.degraded;
  if (!e.path.truth_origin.empty()) json["made_from_ground_truth"] = e.path.truth_origin;
  if (!e.problem.empty()) json["problem"] = e.problem;
  if (e.report) json.update(report_json(*e.report));
  if (e.body) json["body_offset"] = body_json(*e.body, e.body_aligned);
  if (e.clock) {
    json["estimated_clock_offset"] = {{"offset_s", e.clock->offset},
                                      {"low_s", e.clock->low},
                                      {"high_s", e.clock->high},
                                      {"determined", e.clock->determined},
                                      {"compared_poses", e.clock->compared_poses},
                                      {"with_it", report_json(*e.clocked)}};
  }
  return json;
}

}  // namespace

nlohmann::json evaluation_json(const Evaluation& evaluation) {
  const EvaluationSettings& s = evaluation.settings;
  nlohmann::json json = {{"version", lcmslam_version},
                         {"truth", path_json(evaluation.truth)},
                         {"alignment", name_of(s.alignment)},
                         {"association", name_of(s.association)},
                         {"max_difference_s", s.max_time_difference},
                         {"clock_offset_s", s.clock_offset},
                         {"notes", evaluation.notes},
                         {"estimates", nlohmann::json::array()}};
  for (const EvaluatedEstimate& e : evaluation.estimates) json["estimates"].push_back(estimate_json(e));
  return json;
}

}  // namespace lcmslam
