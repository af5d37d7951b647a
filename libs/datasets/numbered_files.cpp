#include <lcmslam/datasets/numbered_files.hpp>

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_digits = 19;  // nanoseconds since 1970; what a long does not hold is left out

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
    char* end = nullptr;
    pattern.digits = std::strtoul(name.c_str() + at + 1, &end, 10);
    if (pattern.digits > most_digits) return std::nullopt;
    at = static_cast<std::size_t>(end - name.c_str());
  }
  if (at >= name.size() || name[at] != 'd') return std::nullopt;
  pattern.suffix = name.substr(at + 1);
  if (pattern.suffix.find('%') != std::string::npos) return std::nullopt;
  return pattern;
}

/// Names in a folder in their order; none when it cannot be read.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The first few, for messages.
std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.empty() ? "nothing" : text + (names.size() > most ? ", ..." : "");
}

/// The pattern of a numbered file's name, by the last number in it; nothing for names without one.
std::optional<std::string> pattern_of(const std::string& name) {
  const char* const decimal = "0123456789";
  const std::size_t last = name.find_last_of(decimal, name.rfind('.'));
  if (last == std::string::npos) return std::nullopt;
  const std::size_t before = name.find_last_not_of(decimal, last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  const std::size_t count = last - first + 1;
  const std::string padding = count > 1 && name[first] == '0' ? "0" + std::to_string(count) : "";
  return name.substr(0, first) + "%" + padding + "d" + name.substr(last + 1);
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
    const std::size_t around = prefix_.size() + suffix_.size();
    if (file.size() <= around || file.size() > around + most_digits) continue;
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

std::string why_no_file_fits(const fs::path& folder, const std::string& pattern) {
  const NumberedFiles files(folder, pattern);
  if (!files.numbers().empty()) return "";
  const fs::path place = files.path(0).parent_path();
  const std::string problem = "no file fits " + pattern + ": ";
  if (!fs::is_directory(place))
    return problem + place.string() + " is no folder; " + folder.string() + " holds " +
           listed(names_in(folder));
  const std::string tried =
      files.path(0).string() + " and " + files.path(1).filename().string() + " are not there, ";
  std::vector<std::string> names = names_in(place);
  std::stable_partition(names.begin(), names.end(), [&](const fs::path& name) {
    return name.extension() == fs::path(pattern).extension();
  });
  const auto is =
      std::find_if(names.begin(), names.end(), [](const std::string& name) { return pattern_of(name); });
  if (is != names.end())
    return problem + tried + "but " + *is + " is, which " +
           (fs::path(pattern).parent_path() / *pattern_of(*is)).string() + " would fit";
  return problem + tried + place.string() + " holds " + listed(names);
}

}  // namespace lcmslam
