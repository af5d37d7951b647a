#pragma once
// A file on its way: it has its name only when it is whole.

#include <lcmslam/files/held_folder.hpp>

namespace lcmslam {

/// Where a file goes.
struct FilePlace {
  HeldFolder folder;
  std::string name;

  /// Throws std::runtime_error when the path has no name or its folder is none.
  FilePlace(const std::filesystem::path& file);
  FilePlace(HeldFolder in, std::string file) : folder(std::move(in)), name(std::move(file)) {}

  std::filesystem::path path() const { return folder.path() / name; }
};

class PartFile {
 public:
  /// Makes NAME.partPID-N, new and locked for as long as this object lives, and takes away the part files of
  /// NAME that nobody locks: their writers are dead. Throws std::runtime_error with the system's reason, and
  /// where NAME is there and no regular file: a link is not followed and not replaced.
  explicit PartFile(const FilePlace& place);
  /// Removes the part file unless it has its name.
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  int descriptor() const { return descriptor_; }
  /// For writers that want a path: it leads to this file, whatever happens to its name.
  std::filesystem::path path() const;

  /// Waits until what was written is on the disk. Throws std::runtime_error with the system's reason.
  void flush();
  /// Gives the file its name, in the place of an older file of that name. Throws likewise.
  void take_name();

 private:
  void remove_stale() const;

  FilePlace place_;
  std::string part_;
  int descriptor_ = -1;
  bool named_ = false;
};

}  // namespace lcmslam
