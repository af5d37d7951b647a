#pragma once
// Where recordings of others lie: $LCMSLAM_DATA, or ../shared/data beside the sources. Tests that need one
// skip without it; recordings of our own are in logs/.

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/source_folder.hpp"

namespace lcmslam {

inline std::filesystem::path recordings_folder() {
  const char* folder = std::getenv("LCMSLAM_DATA");
  return folder != nullptr ? std::filesystem::path(folder) : source_folder() / ".." / "shared" / "data";
}

/// A file or a folder of them.
inline std::filesystem::path recording_path(const std::string& name) {
  return recordings_folder() / name;
}

/// One of logs/.
inline std::filesystem::path own_log(const std::string& name) {
  return source_folder() / "logs" / name;
}

}  // namespace lcmslam

/// For tests of GoogleTest.
#define LCMSLAM_SKIP_WITHOUT(name)                               \
  if (!std::filesystem::exists(::lcmslam::recording_path(name))) \
  GTEST_SKIP() << ::lcmslam::recording_path(name)                \
               << " is not there: set LCMSLAM_DATA to the recordings' folder"
