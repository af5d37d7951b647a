#pragma once
// The files of a page, in memory: a path that is not among them is nowhere.

#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace lcmslam {

struct StaticFile {
  std::string type;  ///< "text/html; charset=utf-8"
  std::string bytes;
  std::string packed;  ///< the same by gzip; empty where that is no smaller
  std::string tag;     ///< of its content, with quotes
};

class StaticFiles {
 public:
  /// All regular files of the folder, not those of folders in it. Throws std::runtime_error when it has no
  /// index.html.
  explicit StaticFiles(const std::filesystem::path& folder);

  /// "/" is index.html; what stands behind a question mark does not matter. Null: there is none.
  const StaticFile* find(const std::string& target) const;

 private:
  std::map<std::string, StaticFile> files_;  // by "/name"
};

}  // namespace lcmslam
