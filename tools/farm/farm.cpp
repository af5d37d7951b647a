#include "tools/farm/farm.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <ostream>
#include <thread>

#include <lcmslam/evaluation/table.hpp>
#include "tools/launch/supervisor.hpp"
#include "tools/output_file.hpp"
#include "tools/run_folder.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds between_looks(20);
constexpr const char* own_output = "batch.txt";  // of a run, beside its results

std::string length_of(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  return seconds < 5400 ? fmt::format("{:.0f} min", seconds / 60) : fmt::format("{:.1f} h", seconds / 3600);
}

/// One farm while it runs.
class FarmRun {
 public:
  FarmRun(const FarmOptions& options, std::ostream& out) : options_(options), out_(out) {}

  std::vector<FarmResult> run() {
    find_what_is_done();
    while (next_ < waiting_.size() || !running_.empty()) {
      while (next_ < waiting_.size() && running_.size() < static_cast<std::size_t>(options_.at_a_time))
        start(waiting_[next_++]);
      throw_when_stopped();
      supervisor_.poll();
      take_ended();
      std::this_thread::sleep_for(between_looks);
    }
    return std::move(results_);
  }

 private:
  struct Running {
    std::size_t job, process;
    Clock::time_point begin;
  };

  fs::path folder_of(std::size_t job) const { return options_.folder / options_.jobs[job].name; }

  void find_what_is_done() {
    results_.resize(options_.jobs.size());
    keys_.resize(options_.jobs.size());
    for (std::size_t i = 0; i < options_.jobs.size(); ++i) {
      throw_when_stopped();
      keys_[i] = options_.key(options_.jobs[i]);
      results_[i] = read_result(folder_of(i), options_.expectations);
      if (results_[i].has_summary && results_[i].key == keys_[i]) continue;
      const bool is_of_a_farm = !results_[i].key.empty() || fs::exists(folder_of(i) / own_output);
      if (!is_of_a_farm) check_run_folder(folder_of(i), options_.force);
      waiting_.push_back(i);
      bytes_left_ += options_.jobs[i].bytes;
    }
    out_ << fmt::format("{} logs: {} done before, {} to run, {} at a time\n", options_.jobs.size(),
                        options_.jobs.size() - waiting_.size(), waiting_.size(), options_.at_a_time)
         << std::flush;
  }

  void start(std::size_t job) {
    const fs::path folder = folder_of(job);
    fs::create_directories(folder);
    fs::remove(folder / "summary.json");  // what stands there is another run's
    fs::remove(folder / own_output);
    ProcessSpec spec;
    spec.name = options_.jobs[job].name;
    spec.arguments = options_.command(options_.jobs[job], folder, keys_[job]);
    spec.log = folder / own_output;
    spec.restart = false;
    supervisor_.start(spec);
    running_.push_back({job, supervisor_.processes().size() - 1, Clock::now()});
  }

  void take_ended() {
    for (std::size_t k = 0; k < running_.size();) {
      if (supervisor_.processes()[running_[k].process].pid != 0) {
        ++k;
        continue;
      }
      take(running_[k]);
      running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }

  void take(const Running& ended) {
    FarmResult& result = results_[ended.job];
    result = read_result(folder_of(ended.job), options_.expectations);
    const std::uintmax_t bytes = options_.jobs[ended.job].bytes;
    bytes_done_ += bytes;
    bytes_left_ -= bytes;
    const double elapsed = seconds_since(begin_);
    const double left =
        elapsed * static_cast<double>(bytes_left_) / std::max(1.0, static_cast<double>(bytes_done_));
    const auto metres = [](const std::optional<double>& ate) {
      return ate ? fixed_number(*ate, 4) + " m" : std::string("-");
    };
    out_ << fmt::format("[{}/{}] {}: {}, icp {}, fastslam {}, {:.1f} s{}\n", ++ended_, waiting_.size(),
                        result.name, result.passed() ? "passed" : result.failures.front(), metres(result.icp),
                        metres(result.fastslam), seconds_since(ended.begin),
                        bytes_left_ > 0 ? ", about " + length_of(left) + " left" : "")
         << std::flush;
  }

  static double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  }

  const FarmOptions& options_;
  std::ostream& out_;
  Supervisor supervisor_;
  std::vector<std::string> keys_;
  std::vector<FarmResult> results_;
  std::vector<std::size_t> waiting_;  // jobs
  std::vector<Running> running_;
  std::size_t next_ = 0, ended_ = 0;
  std::uintmax_t bytes_left_ = 0, bytes_done_ = 0;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace

std::vector<FarmResult> run_farm(const FarmOptions& options, std::ostream& out) {
  return FarmRun(options, out).run();
}

int exit_code_of(const std::vector<FarmResult>& results) {
  int code = 0;
  for (const FarmResult& result : results)
    code = std::max(code, !result.has_summary ? 2 : result.passed() ? 0 : 1);
  return code;
}

}  // namespace lcmslam
