#include "tools/launch/log_files.hpp"

#include <algorithm>
#include <fstream>

namespace lcmslam {
namespace {

std::filesystem::path older(const std::filesystem::path& log, int number) {
  return log.parent_path() / (log.stem().string() + "." + std::to_string(number) + log.extension().string());
}

std::string last_line(const std::filesystem::path& log) {
  constexpr std::streamoff enough = 16'384;  // bytes
  std::ifstream text(log, std::ios::ate);
  text.seekg(std::max<std::streamoff>(0, text.tellg() - enough));
  std::string last;
  for (std::string line; std::getline(text, line);)
    if (!line.empty()) last = line;
  return last;
}

// To its end as it is now: what comes in the next microseconds is lost. A stream that copies says nothing of
// what it had no room for.
bool copy_whole(const std::filesystem::path& log, const std::filesystem::path& copy) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(log, error);
  if (error) return false;
  std::ifstream in(log, std::ios::binary);
  std::ofstream out(copy, std::ios::binary | std::ios::trunc);
  out << in.rdbuf();
  out.close();
  return out && std::filesystem::file_size(copy, error) >= size && !error;
}

}  // namespace

bool rotate_log(const std::filesystem::path& log, std::uintmax_t most, int files) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(log, error);
  if (error || most == 0 || size <= most) return false;
  if (files > 1) {
    const std::filesystem::path copy = older(log, 1).string() + ".part";
    if (!copy_whole(log, copy)) {  // a full disk: better a long log than none
      std::filesystem::remove(copy, error);
      return false;
    }
    for (int i = files - 2; i >= 1; --i) std::filesystem::rename(older(log, i), older(log, i + 1), error);
    std::filesystem::rename(copy, older(log, 1), error);
    if (error) return false;
  }
  std::filesystem::resize_file(log, 0, error);  // opened to append: the process goes on at the new end
  return !error;
}

std::string last_words(const std::filesystem::path& log) {
  std::string last = last_line(log);
  if (last.empty()) last = last_line(older(log, 1));
  const std::string level = "[error] ";
  const std::size_t at = last.find(level);
  return at == std::string::npos ? last : last.substr(at + level.size());
}

}  // namespace lcmslam
