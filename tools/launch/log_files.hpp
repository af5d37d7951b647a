#pragma once
// The logs of a process: NAME.txt is under way, NAME.1.txt was before it, NAME.2.txt before that.

#include <cstdint>
#include <filesystem>
#include <string>

namespace lcmslam {

/// Begins a new log when this one is larger than `most` bytes (0: never) and keeps `files` in all. The
/// process has its file open and goes on in it: what it holds is copied away and cut off. True when it was
/// done. What cannot be done is left for the next time.
bool rotate_log(const std::filesystem::path& log, std::uintmax_t most, int files);

/// The last line of a log, or of the one before where this one is empty; without time and level in front:
/// what a process said of its end.
std::string last_words(const std::filesystem::path& log);

}  // namespace lcmslam
