#include "tools/study/option_use.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <map>

namespace lcmslam {
namespace {

struct OptionUse {
  std::vector<std::string> options;
  bool one_seed = false;
};

const std::map<std::string, OptionUse>& uses() {
  static const std::map<std::string, OptionUse> all = {
      {"demo", {{"--seeds", "--config", "--data", "--seconds", "--set"}}},
      {"report", {{"--seeds", "--data", "--out", "--quick"}}},
      {"features", {{"--data", "--apart", "--starts", "--keypoints"}}},
      {"pairs",
       {{"--data", "--apart", "--starts", "--method", "--max-translation", "--max-rotation",
         "--clock-offset"}}},
      {"landmarks", {{"--seeds", "--config", "--data", "--set", "--robot", "--description"}}},
      {"filter", {{"--seeds", "--config", "--set", "logs", "--scene"}}},
      {"consistency", {{"--config", "--set", "logs", "--clock-offset"}}},
      {"depth-filter", {{"--seeds"}, true}},
      {"resampling", {{"--seeds", "--config", "--data", "--set"}}},
      {"faults", {{"--seeds", "--data", "--minutes"}, true}},
      {"kills", {{"--seeds", "--minutes"}, true}},
      {"endurance", {{"--seeds", "--config", "--set", "--laps"}, true}}};
  return all;
}

std::string called(const std::string& study) {
  if (study == "demo") return "the study of the live demo";
  return study == "report" ? "the report" : "--only " + study;
}

}  // namespace

std::optional<std::string> option_problem(const std::string& study, const GivenOptions& given) {
  const OptionUse& use = uses().at(study);
  for (const std::string& name : given.names) {
    if (std::find(use.options.begin(), use.options.end(), name) != use.options.end()) continue;
    std::string used;
    for (const std::string& option : use.options) used.append(used.empty() ? "" : ", ").append(option);
    return fmt::format("{} does not use {}; it takes {}", called(study), name, used);
  }
  if (use.one_seed && given.seeds > 1)
    return called(study) + " takes one seed, not " + std::to_string(given.seeds);
  return std::nullopt;
}

}  // namespace lcmslam
