#pragma once
// `lcmslam batch` over many logs, here or on Slurm.

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace lcmslam {

/// As `lcmslam batch` is asked.
struct FarmArguments {
  std::string config, calibration, out, expect, list, share;
  std::vector<std::string> logs, overrides;
  double from = 0, to = 0;  ///< s
  int threads = 1;
  int jobs = 0;  ///< 0: as many as processors
  int pack = 1;
  bool slurm = false;
  bool force = false;  ///< overwrite what is not of a farm, too
  bool kitti = false;  ///< trajectories in KITTI's format too
};

/// By which a farm knows whether a result is of this log, these options and this program. Throws as
/// run_key().
std::string farm_key(const FarmArguments& arguments, const std::filesystem::path& log);

/// Whether that is more than one run in this process.
bool is_farm(const FarmArguments& arguments);

/// Why that cannot be done, in words; none: it can.
std::optional<std::string> farm_problem(const FarmArguments& arguments);

/// Gives the exit code: 0 all passed (or handed over), 1 some did not reach what was expected, 2 some have no
/// result. Throws std::runtime_error, ConfigError.
int batch_farm(const FarmArguments& arguments, std::ostream& out);

}  // namespace lcmslam
