#pragma once
// What a run must reach (--expect FILE), e.g.
//
//   icp: {ate: 0.02, tracked: 0.95}     # of every log
//   fastslam: {ate: 0.03}
//   logs:
//     "office_*": {icp: {ate: 0.03}}    # of these instead; the last pattern that fits says it

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Of one path, in the words of summary.json. -1: no bar.
struct PathBars {
  double ate = -1, rpe = -1, tracked = -1, lost = -1;

  void describe(SettingsVisitor& s) {
    s.number("ate", ate, "m", {-1, 1e9}, "absolute trajectory error (RMSE after alignment), at most");
    s.number("rpe", rpe, "m", {-1, 1e9}, "relative pose error over a second (RMSE), at most");
    s.number("tracked", tracked, "", {-1, 1}, "share of the truth's poses that have an estimate, at least");
    s.number("lost", lost, "", {-1, 1e9}, "poses that say LOST, at most");
  }
};

struct RunBars {
  PathBars icp, fastslam, odometry;
};

class Expectations {
 public:
  /// None: every run passes that mapped what it was given.
  Expectations() = default;
  /// Throws ConfigError with file and line.
  explicit Expectations(const std::filesystem::path& file);

  /// What the run of that name did not reach, in words; of its events as well. Empty: it passed.
  std::vector<std::string> failures(const std::string& name, const nlohmann::json& summary) const;

 private:
  RunBars bars_of(const std::string& name) const;

  RunBars all_;
  std::vector<std::pair<std::string, ConfigNode>> some_;  // by shell pattern
};

}  // namespace lcmslam
