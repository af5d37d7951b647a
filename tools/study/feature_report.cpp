// The study's result as table, CSV and JSON.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <lcmslam/evaluation/table.hpp>
#include "tools/study/feature_study.hpp"

namespace lcmslam {
namespace {

/// "0.53 / 0.44 / 0.42", one number a distance.
std::string by_distance(const MethodResult& method, double DistanceScore::*value, int decimals) {
  std::string text;
  for (const DistanceScore& score : method.scores)
    text += (text.empty() ? "" : " / ") + fixed_number(score.*value, decimals);
  return text;
}

/// "+0.062 (+0.051, +0.073)".
std::string with_interval(const Interval& i, bool difference) {
  return difference ? fmt::format("{:+.3f} ({:+.3f}, {:+.3f})", i.value, i.low, i.high)
                    : fmt::format("x {:.2f} ({:.2f}, {:.2f})", i.value, i.low, i.high);
}

std::string comparison_table(const FeatureStudyResult& result) {
  Table table({"against dlib SURF, 95 %", "frames apart", "repeatability", "precision", "correct matches"});
  bool any = false;
  for (const MethodResult& method : result.methods)
    for (std::size_t d = 0; d < method.against_dlib.size(); ++d, any = true) {
      const ScoreComparison& c = method.against_dlib[d];
      table.add({method.row.name, std::to_string(result.apart[d]), with_interval(c.repeatability, true),
                 with_interval(c.precision, true), with_interval(c.correct, false)});
    }
  return any ? "\n" + table.text() : "";
}

nlohmann::json to_json(const Interval& i) {
  return {{"value", i.value}, {"low", i.low}, {"high", i.high}};
}

}  // namespace

std::string feature_table(const FeatureStudyResult& result) {
  Table table({"", "keypoints with depth", "repeatability", "precision", "correct matches", "ms an image"});
  for (const MethodResult& method : result.methods)
    table.add({method.row.name, by_distance(method, &DistanceScore::keypoints, 0),
               by_distance(method, &DistanceScore::repeatability, 3),
               by_distance(method, &DistanceScore::precision, 3),
               by_distance(method, &DistanceScore::correct, 1), fixed_number(method.milliseconds, 1)});
  std::string text = table.text();
  for (std::size_t d = 0; d < result.apart.size(); ++d)
    text +=
        fmt::format("{} frames apart: {} pairs, {} left out without a pose to judge by\n", result.apart[d],
                    result.methods.empty() ? 0 : result.methods.front().scores[d].pairs, result.left_out[d]);
  if (result.unreadable > 0)
    text += fmt::format("{} pairs with an image missing or without a measured pose\n", result.unreadable);
  return text + comparison_table(result);
}

std::string feature_csv(const FeatureStudyResult& result) {
  std::string text = "method,apart,pairs,left_out,keypoints,repeatability,precision,correct,milliseconds";
  for (const char* name : {"repeatability_difference", "precision_difference", "correct_ratio"})
    text += fmt::format(",{0},{0}_low,{0}_high", name);
  text += "\n";
  for (const MethodResult& method : result.methods)
    for (std::size_t d = 0; d < result.apart.size(); ++d) {
      const DistanceScore& s = method.scores[d];
      text += fmt::format("\"{}\",{},{},{},{:.1f},{:.4f},{:.4f},{:.2f},{:.3f}", method.row.name,
                          result.apart[d], s.pairs, result.left_out[d], s.keypoints, s.repeatability,
                          s.precision, s.correct, method.milliseconds);
      if (method.against_dlib.empty()) {
        text += ",,,,,,,,,\n";
        continue;
      }
      const ScoreComparison& c = method.against_dlib[d];
      for (const Interval& i : {c.repeatability, c.precision, c.correct})
        text += fmt::format(",{:.4f},{:.4f},{:.4f}", i.value, i.low, i.high);
      text += "\n";
    }
  return text;
}

nlohmann::json feature_json(const FeatureStudyResult& result, const FeatureStudySettings& settings) {
  nlohmann::json methods = nlohmann::json::array();
  for (const MethodResult& method : result.methods) {
    nlohmann::json curve = nlohmann::json::array();
    for (std::size_t d = 0; d < result.apart.size(); ++d) {
      const DistanceScore& s = method.scores[d];
      curve.push_back({{"apart", result.apart[d]},
                       {"pairs", s.pairs},
                       {"left_out", result.left_out[d]},
                       {"keypoints", s.keypoints},
                       {"repeatability", s.repeatability},
                       {"precision", s.precision},
                       {"correct_matches", s.correct}});
      if (method.against_dlib.empty()) continue;
      const ScoreComparison& c = method.against_dlib[d];
      curve.back()["against_dlib"] = {{"repeatability_difference", to_json(c.repeatability)},
                                      {"precision_difference", to_json(c.precision)},
                                      {"correct_ratio", to_json(c.correct)}};
    }
    methods.push_back({{"name", method.row.name}, {"milliseconds", method.milliseconds}, {"curve", curve}});
  }
  return {{"settings",
           {{"apart", settings.apart},
            {"starts", settings.starts},
            {"keypoints", settings.keypoints},
            {"ratio", settings.ratio},
            {"repeatability_pixels", settings.tolerances.repeatability},
            {"precision_pixels", settings.tolerances.precision},
            {"pose_min_inliers", settings.pose.min_inliers},
            {"pose_max_rotation_degrees", settings.pose.max_rotation},
            {"pose_max_translation_m", settings.pose.max_translation}}},
          {"unreadable_pairs", result.unreadable},
          {"methods", methods}};
}

}  // namespace lcmslam
