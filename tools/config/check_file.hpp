#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

/// Reads a file with the readers that the processes use, told by what stands in it: a graph or preset, a
/// scene, a data set's description, or a calibration. Gives what it is: "a graph". Throws ConfigError;
/// overrides (section.key=value) are for graphs.
std::string check_file(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

/// What a graph's camera would open and is not there, with the place that names it, a line each. Whoever
/// writes a configuration may write those files later.
std::vector<std::string> missing_files(const std::filesystem::path& file,
                                       const std::vector<std::string>& overrides = {});

}  // namespace lcmslam
