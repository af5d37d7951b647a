#pragma once
// How the stock Java program lcm-spy is started. Its own start script fails on Java 17 and knows no types.

#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

/// What it needs, as far as this machine has it (empty: not found).
struct SpyParts {
  std::filesystem::path java;
  bool java_draws = false;  ///< a Java with windows, not the headless one
  std::filesystem::path lcm_jar, chart_jar;
  std::filesystem::path types_jar, plugin_jar;  ///< ours, built where a Java compiler is
  std::string display;                          ///< of X
};

/// Whether an X server of this machine (":0") takes connections; true for those of others, unasked.
bool display_answers(const std::string& display);

/// Looks in PATH (`search_path`: folders with ':' between), among installed Java libraries and in the
/// folder of our own.
SpyParts find_spy_parts(const std::string& search_path, const std::vector<std::filesystem::path>& libraries,
                        const std::filesystem::path& own, const std::string& display);

/// What is missing and the line that mends it; empty when nothing is. To start it, a display and a Java that
/// draws are needed as well.
std::string missing_part(const SpyParts& parts);
std::string spy_obstacle(const SpyParts& parts);

/// Program and arguments.
std::vector<std::string> spy_arguments(const SpyParts& parts, const std::string& lcm_url,
                                       const std::vector<std::string>& more);

}  // namespace lcmslam
