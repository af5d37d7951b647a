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

/// Takes all the room that a disk has left, as long as it lives, so that a map file there cannot be written.
class Ballast {
 public:
  /// `map`: the file. SQLite writes where it has written before, and for minutes would need no more room: its
  /// log is written back and cut to nothing first. Throws StoreError.
  Ballast(std::filesystem::path folder, const std::filesystem::path& map);
  ~Ballast();
  Ballast(const Ballast&) = delete;
  Ballast& operator=(const Ballast&) = delete;

  /// To the last byte again: others may have given room away.
  void fill();

 private:
  std::filesystem::path file_;
};

}  // namespace lcmslam
