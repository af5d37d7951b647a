#include "tools/farm/farm_jobs.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

/// The last `parts` parts of a path, as one name of a folder.
std::string name_of(const fs::path& log, std::size_t parts) {
  std::string name = log.stem().string();
  fs::path folder = log.parent_path();
  for (std::size_t i = 1; i < parts && folder.has_filename(); ++i, folder = folder.parent_path())
    name = folder.filename().string() + "__" + name;
  return name;
}

}  // namespace

std::vector<FarmJob> farm_jobs(const std::vector<fs::path>& logs) {
  std::vector<FarmJob> jobs;
  std::set<fs::path> known;
  for (const fs::path& log : logs) {
    const fs::path whole = fs::weakly_canonical(log);
    if (!fs::is_regular_file(whole)) throw std::runtime_error(log.string() + ": there is no such log");
    if (!known.insert(whole).second) throw std::runtime_error(log.string() + ": the log is named twice");
    jobs.push_back({"", whole, fs::file_size(whole)});
  }
  // Longer names for those that are not alone with theirs, until all are.
  std::vector<std::size_t> parts(jobs.size(), 1);
  constexpr std::size_t most = 64;
  for (std::size_t round = 1; round < most; ++round) {
    std::map<std::string, std::vector<std::size_t>> of_name;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
      jobs[i].name = name_of(jobs[i].log, parts[i]);
      of_name[jobs[i].name].push_back(i);
    }
    if (of_name.size() == jobs.size()) return jobs;
    for (const auto& [name, those] : of_name)
      if (those.size() > 1)
        for (const std::size_t i : those) ++parts[i];
  }
  throw std::runtime_error("logs whose files differ in their extension alone: rename one of them");
}

std::vector<fs::path> read_log_list(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::vector<fs::path> logs;
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back())) != 0) line.pop_back();
    if (!line.empty() && line.front() != '#') logs.push_back(file.parent_path() / line);
  }
  if (logs.empty()) throw std::runtime_error(file.string() + ": names no log");
  return logs;
}

FarmShare parse_share(const std::string& text) {
  FarmShare share;
  const char* const end = text.data() + text.size();
  const auto index = std::from_chars(text.data(), end, share.index);
  const bool slash = index.ec == std::errc() && index.ptr != end && *index.ptr == '/';
  const auto count = slash ? std::from_chars(index.ptr + 1, end, share.count) : index;
  if (!slash || count.ec != std::errc() || count.ptr != end || share.index < 0 || share.index >= share.count)
    throw std::runtime_error("--share " + text + ": must be K/N with K from 0 to N-1, e.g. 2/16");
  return share;
}

std::vector<FarmJob> share_of(const std::vector<FarmJob>& jobs, const FarmShare& share) {
  std::vector<FarmJob> mine;
  for (std::size_t i = static_cast<std::size_t>(share.index); i < jobs.size();
       i += static_cast<std::size_t>(share.count))
    mine.push_back(jobs[i]);
  return mine;
}

}  // namespace lcmslam
