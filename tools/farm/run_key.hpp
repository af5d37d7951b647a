#pragma once
// Whether a result is that of the same log, configuration and build.

#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

/// Of a batch run, all that its result depends on.
struct RunInputs {
  std::filesystem::path log;
  std::filesystem::path config;
  std::vector<std::string> overrides;
  std::filesystem::path calibration;  ///< empty: the log's own
  double from = 0, to = 0;            ///< s
  bool kitti = false;                 ///< what is written besides
};

/// Hex digits of a BLAKE2b hash over the log's bytes, the configuration with what it includes, and this
/// program's own file. Throws std::runtime_error for a file that cannot be read, ConfigError.
std::string run_key(const RunInputs& inputs);

}  // namespace lcmslam
