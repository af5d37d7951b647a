#pragma once
// Files that are numbered by frame, like image/%05d.jpg.

#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

class NumberedFiles {
 public:
  /// Whether the pattern holds exactly one %d or %0Nd (N at most 19), in the file's name.
  static bool is_pattern(const std::string& pattern);

  /// `pattern` (see is_pattern) is relative to the folder, which is searched once.
  NumberedFiles(const std::filesystem::path& folder, const std::string& pattern);

  std::filesystem::path path(long number) const;

  /// Numbers that exist, ascending.
  const std::vector<long>& numbers() const { return numbers_; }
  bool has(long number) const;

 private:
  std::filesystem::path folder_;
  std::string prefix_, suffix_;
  std::size_t digits_ = 0;
  std::vector<long> numbers_;
};

/// Where no file fits a pattern: the paths that were tried, what is there in their place, and the pattern
/// that would fit it. Empty when a file fits.
std::string why_no_file_fits(const std::filesystem::path& folder, const std::string& pattern);

}  // namespace lcmslam
