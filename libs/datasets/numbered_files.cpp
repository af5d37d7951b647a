#include <lcmslam/datasets/numbered_files.hpp>

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

// A name with one %d or %0Nd, cut in three. (std::regex would do it too, but g++ 12 warns inside it when
// sanitizers are on.)
struct Pattern {
  std::string prefix, suffix;
  std::size_t digits = 0;  // at least so many, with leading zeros
};

std::optional<Pattern> parse(const std::string& name) {
  const std::size_t percent = name.find('%');
  if (percent == std::string::npos) return std::nullopt;
  Pattern pattern;
  pattern.prefix = name.substr(0, percent);
  std::size_t at = percent + 1;
  if (at + 1 < name.size() && name[at] == '0' && name[at + 1] >= '1' && name[at + 1] <= '9') {
    pattern.digits = static_cast<std::size_t>(name[at + 1] - '0');
    at += 2;
  }
  if (at >= name.size() || name[at] != 'd') return std::nullopt;
  pattern.suffix = name.substr(at + 1);
  if (pattern.suffix.find('%') != std::string::npos) return std::nullopt;
  return pattern;
}

}  // namespace

bool NumberedFiles::is_pattern(const std::string& pattern) {
  const fs::path path(pattern);
  return path.parent_path().string().find('%') == std::string::npos &&
         parse(path.filename().string()).has_value();
}

NumberedFiles::NumberedFiles(const fs::path& folder, const std::string& pattern)
    : folder_((folder / pattern).parent_path()) {
  const auto parts = parse(fs::path(pattern).filename().string());
  if (!parts) return;
  prefix_ = parts->prefix;
  suffix_ = parts->suffix;
  digits_ = parts->digits;

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
