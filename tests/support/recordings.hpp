#pragma once
// Where recordings of others lie: $LCMSLAM_DATA, or ../shared/data beside the sources. Tests that need one
// skip without it; recordings of our own are in logs/.

#include <cstdlib>
#include <filesystem>
#include <string>

namespace lcmslam::testing {

inline std::filesystem::path recordings() {
  const char* folder = std::getenv("LCMSLAM_DATA");
  return folder != nullptr ? std::filesystem::path(folder)
                           : std::filesystem::path(LCMSLAM_SOURCE_DIR) / ".." / "shared" / "data";
}

/// A file or a folder of them.
inline std::filesystem::path recording(const std::string& name) {
  return recordings() / name;
}

/// One of logs/.
inline std::filesystem::path own_log(const std::string& name) {
  return std::filesystem::path(LCMSLAM_SOURCE_DIR) / "logs" / name;
}

}  // namespace lcmslam::testing

/// For tests of GoogleTest.
#define LCMSLAM_SKIP_WITHOUT(name)                                   \
  if (!std::filesystem::exists(::lcmslam::testing::recording(name))) \
  GTEST_SKIP() << ::lcmslam::testing::recording(name)                \
               << " is not there: set LCMSLAM_DATA to the recordings' folder"
