// The study's result as table, CSV and JSON.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evaluation/table.hpp"
#include "study/feature_study.hpp"

namespace lcmslam {
namespace {

/// "0.53 / 0.44 / 0.42", one number a distance.
std::string by_distance(const MethodResult& method, double DistanceScore::*value, int decimals) {
  std::string text;
  for (const DistanceScore& score : method.scores)
    text += (text.empty() ? "" : " / ") + fixed_number(score.*value, decimals);
  return text;
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
  return text;
}

std::string feature_csv(const FeatureStudyResult& result) {
  std::string text = "method,apart,pairs,left_out,keypoints,repeatability,precision,correct,milliseconds\n";
  for (const MethodResult& method : result.methods)
    for (std::size_t d = 0; d < result.apart.size(); ++d) {
      const DistanceScore& s = method.scores[d];
      text += fmt::format("\"{}\",{},{},{},{:.1f},{:.4f},{:.4f},{:.2f},{:.3f}\n", method.row.name,
                          result.apart[d], s.pairs, result.left_out[d], s.keypoints, s.repeatability,
                          s.precision, s.correct, method.milliseconds);
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
