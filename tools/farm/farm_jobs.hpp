#pragma once
// Which logs a farm runs, and where the results of each go.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

struct FarmJob {
  std::string name;  ///< of its folder below the farm's
  std::filesystem::path log;
  std::uintmax_t bytes = 0;  ///< of the log: how long it takes, roughly
};

/// Named after their files; those of the same name by as much of their folders as tells them apart. Throws
/// std::runtime_error for a log that is named twice or is not there.
std::vector<FarmJob> farm_jobs(const std::vector<std::filesystem::path>& logs);

/// A log a line; empty lines and those that begin with # are passed over, paths are relative to the file.
/// Throws std::runtime_error.
std::vector<std::filesystem::path> read_log_list(const std::filesystem::path& file);

/// One of several machines' or engines' shares of a farm: jobs index, index + count, ...
struct FarmShare {
  int index = 0;
  int count = 1;
};

/// "2/16", from 0. Throws std::runtime_error for anything else.
FarmShare parse_share(const std::string& text);
std::vector<FarmJob> share_of(const std::vector<FarmJob>& jobs, const FarmShare& share);

}  // namespace lcmslam
