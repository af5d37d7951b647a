#pragma once
// Where the tests run: a bus of their own, the built programs, a temporary folder, patience.

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "tests/support/source_folder.hpp"

namespace lcmslam::integration {

/// What main() of every integration test does: enters the private bus before any thread starts (where
/// the machine forbids it: the shared bus with a random port, and says so), then runs the tests.
int run_tests(int argc, char** argv);

/// Folder of the programs; LCMSLAM_PROGRAMS overrides it.
std::filesystem::path program_folder();

/// A folder that is removed at the end, unless the test failed: then its path is printed.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// Looks every 20 ms until the predicate holds; false when it does not within the time (which is longer
/// under a sanitizer).
bool wait_until(const std::function<bool()>& predicate, double seconds);

/// Sanitizers slow programs down and widen them in memory.
#if defined(__SANITIZE_ADDRESS__)
constexpr double patience_factor = 5;
constexpr double memory_factor = 5;
#else
constexpr double patience_factor = 1;
constexpr double memory_factor = 1;
#endif

}  // namespace lcmslam::integration
