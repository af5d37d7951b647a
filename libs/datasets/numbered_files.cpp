#include "datasets/numbered_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <regex>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

const std::regex& number_pattern() {
  static const std::regex pattern("^([^%/]*)%(?:0([1-9]))?d([^%/]*)$");
  return pattern;
}

}  // namespace

bool NumberedFiles::is_pattern(const std::string& pattern) {
  const fs::path path(pattern);
  return path.parent_path().string().find('%') == std::string::npos &&
         std::regex_match(path.filename().string(), number_pattern());
}

NumberedFiles::NumberedFiles(const fs::path& folder, const std::string& pattern)
    : folder_((folder / pattern).parent_path()) {
  std::smatch parts;
  const std::string name = fs::path(pattern).filename().string();
  if (!std::regex_match(name, parts, number_pattern())) return;
  prefix_ = parts[1];
  suffix_ = parts[3];
  digits_ = parts[2].matched ? static_cast<std::size_t>(std::stoi(parts[2])) : 0;

  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_, error)) {
    const std::string file = entry.path().filename().string();
    if (file.size() <= prefix_.size() + suffix_.size() || file.size() > prefix_.size() + suffix_.size() + 9)
      continue;
    const long number = std::strtol(file.c_str() + prefix_.size(), nullptr, 10);
    if (number >= 0 && path(number).filename() == file) numbers_.push_back(number);
  }
  std::sort(numbers_.begin(), numbers_.end());
}

fs::path NumberedFiles::path(long number) const {
  std::string digits = std::to_string(number);
  if (digits.size() < digits_) digits.insert(0, digits_ - digits.size(), '0');
  return folder_ / (prefix_ + digits + suffix_);
}

bool NumberedFiles::has(long number) const {
  return std::binary_search(numbers_.begin(), numbers_.end(), number);
}

}  // namespace lcmslam
