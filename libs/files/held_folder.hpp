#pragma once
// A folder that is held open: what is put into it goes there and nowhere else, whatever somebody puts in the
// place of its name meanwhile.

#include <filesystem>
#include <memory>
#include <string>

namespace lcmslam {

class HeldFolder {
 public:
  /// A folder that the user names: symbolic links in its path are followed. Throws std::runtime_error when it
  /// is none or may not be entered.
  explicit HeldFolder(const std::filesystem::path& folder);

  /// A folder below this one by a name that a stranger gave, "tour" or "tour/second", made where it is
  /// missing. Throws std::runtime_error, and makes nothing, unless check_name() lets every part pass; and
  /// when a part is there already but is no folder of its own (a symbolic link, say).
  HeldFolder below(const std::string& name) const;

  /// As the user or the stranger named it, for messages.
  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return *descriptor_; }

 private:
  HeldFolder(std::filesystem::path path, int descriptor);

  std::filesystem::path path_;
  std::shared_ptr<const int> descriptor_;  // closed by the last that holds it
};

/// A name that a stranger gives to a file or a folder: 1 to 100 letters, digits, dots, dashes and
/// underscores, no dot in front. Throws std::runtime_error that says so.
void check_name(const std::string& name);

}  // namespace lcmslam
