#include "tools/study/report_command.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <iostream>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/runtime/machine.hpp>
#include "tools/run_folder.hpp"
#include "tools/study/report/study_run.hpp"
#include "tools/time_left.hpp"

namespace lcmslam {
namespace {

/// In a terminal it overwrites itself.
std::string progress_text(const std::string& name, std::size_t done, double part, std::size_t all,
                          double seconds) {
  const double share = (static_cast<double>(done) + part) / static_cast<double>(all);
  std::string text = fmt::format("{:4.0f} s  {}/{}  {}", seconds, done + 1, all, name);
  if (const auto left = time_left(seconds, share)) text += fmt::format("  about {:.0f} s left", *left);
  return text;
}

}  // namespace

std::vector<std::string> report_names() {
  std::vector<std::string> names;
  for (const Experiment& experiment : study_experiments()) names.push_back(experiment.name);
  return names;
}

int report_command(std::string out, const std::string& only, const std::string& data, bool quick,
                   std::vector<int> seeds) {
  keep_freed_memory();
  spdlog::set_level(spdlog::level::warn);  // mappers say much, and there are hundreds of runs
  const auto experiments = experiments_named(study_experiments(), only);
  if (seeds.empty()) seeds = quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 3, 4, 5};
  if (out.empty()) out = new_run_folder("study-report");
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  const auto line = [&](const std::string& text, bool stays) {
    std::cout << (terminal ? "\r\x1b[K" : "") << text << (terminal && !stays ? "" : "\n") << std::flush;
  };
  StudyRunSettings settings;
  settings.out = out;
  settings.data = data;
  settings.quick = quick;
  settings.seeds = seeds;
  settings.page = share_path("study");
  settings.progress = [&](const std::string& name, std::size_t done, double part, std::size_t all,
                          double seconds) {
    if (terminal || part == 0) line(progress_text(name, done, part, all, seconds), false);
  };
  settings.ended = [&](const std::string& name, const std::string& error) {
    if (!error.empty()) line(name + " failed: " + error, true);
  };
  const bool good = run_study(experiments, settings);
  line((settings.out / "index.html").string() + ", report.json", true);
  return good ? 0 : 1;
}

}  // namespace lcmslam
