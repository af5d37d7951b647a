#pragma once
// The kitchen, lap after lap with its time-of-flight head, undisturbed and at the same time again while every
// half minute one of the processes is killed: is anything lost, and how much worse is the map?

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/study/faults/faults_study.hpp"

namespace lcmslam {

/// Both runs for `minutes`, each a process on a bus of its own. The results in `folder`/undisturbed and
/// `folder`/killed. Throws std::runtime_error where a run does not come to its end.
nlohmann::json study_kills(const FaultsStudySettings& settings, const std::filesystem::path& folder);

/// What the map's file has of both runs, and what the kills did.
std::string kills_table(const nlohmann::json& report);

}  // namespace lcmslam
