#pragma once
// The studies that `lcmslam study --only NAME` runs into folders of their own: on logs and recordings that a
// user names.

#include <string>
#include <vector>

#include "tools/study/faults/faults_study.hpp"
#include "tools/study/feature_study.hpp"
#include "tools/study/pair_study.hpp"

namespace lcmslam {

/// What the command line said; each study takes its part (option_use.hpp).
struct OwnStudyOptions {
  std::vector<int> seeds = {1, 2, 3, 4, 5};
  std::string config, data, description, scene, method;
  std::vector<std::string> overrides, logs;
  int robot = 0, laps = 40;
  FeatureStudySettings features;
  PairStudySettings pairs;
  FaultsStudySettings faults;
};

const std::vector<std::string>& own_studies();

/// Exit code. Throws std::invalid_argument where what it needs is not given.
int run_own_study(const std::string& name, OwnStudyOptions options);

}  // namespace lcmslam
