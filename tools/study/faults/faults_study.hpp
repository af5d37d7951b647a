#pragma once
// How well the graph stands what goes wrong on a robot: stamps that jump, processes that die or stop,
// covered, late, doubled and foreign cameras, strangers on the bus, a full disk. Runs live, on the simulated
// kitchen and on a recording.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/study/faults/fault_run.hpp"

namespace lcmslam {

struct FaultsStudySettings {
  std::string recording;  ///< folder of a data set, besides the simulation; empty: none
  std::string lcm_url;
  double minutes = 10;  ///< that the runs take together
  std::uint64_t seed = 1;
};

struct FaultsStudyRun {
  std::string scene;
  std::uint64_t seed = 0;
  std::vector<Fault> faults;
  FaultRunResult result;
};

/// First undisturbed runs of each scene, then disturbed ones by turns, each in `folder`/SCENE-SEED, whose
/// disk ends with it.
std::vector<FaultsStudyRun> study_faults(const FaultsStudySettings& settings,
                                         const std::filesystem::path& folder);

std::string faults_table(const std::vector<FaultsStudyRun>& runs);
/// Of each fault: who told it when, and how both mappers came out of it.
std::string responses_table(const std::vector<FaultsStudyRun>& runs);
nlohmann::json run_json(const FaultsStudyRun& run);
nlohmann::json faults_json(const std::vector<FaultsStudyRun>& runs);

}  // namespace lcmslam
