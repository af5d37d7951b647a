#pragma once
// A disk that a run can fill.

#include <filesystem>

namespace lcmslam {

/// This process and those it starts see mounts of their own from now on. Before any thread; false where that
/// is forbidden.
bool own_mounts();

/// A folder in memory that holds `megabytes`, as long as this lives. Needs own_mounts().
class SmallDisk {
 public:
  /// Throws std::system_error.
  SmallDisk(std::filesystem::path folder, int megabytes);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  std::filesystem::path folder_;
};

}  // namespace lcmslam
