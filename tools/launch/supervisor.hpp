#pragma once
// Starts processes, notices their end, restarts them, stops them all. No process outlives the
// supervisor, not even when it is killed with -9 (the kernel then sends them SIGTERM).

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lcmslam {

struct ProcessSpec {
  std::string name;
  std::vector<std::string> arguments;  ///< program first
  std::filesystem::path log;           ///< its standard output and error are appended there
  bool restart = true;                 ///< when it ends and was not asked to (its exit code is not 0)
  bool stop_last = false;              ///< only when the others have stopped: it keeps what they make
  std::string on_restart{};            ///< argument that a restart adds, with its number behind it
};

class Supervisor {
 public:
  using Clock = std::chrono::steady_clock;

  struct State {
    ProcessSpec spec;
    pid_t pid = 0;  ///< 0: does not run
    int starts = 0;
    bool refused = false;   ///< ended with exit 2: its configuration is wrong, starting it again is no use
    bool failed = false;    ///< its last end was not that of a process that stops as asked
    bool killed = false;    ///< by this supervisor, because it did not stop
    std::string last_exit;  ///< "exit 1", "signal 9 (Killed)"; empty before the first
    Clock::time_point started{};
    Clock::time_point restart_at{};
    std::chrono::seconds backoff{1};
  };

  ~Supervisor() { stop(); }

  /// Throws std::runtime_error when the program cannot be started.
  void start(const ProcessSpec& spec);

  /// Collects what ended and restarts it in time; gives what happened, in words.
  std::vector<std::string> poll();

  /// INT, then TERM, then KILL, each after its patience. Gives what went wrong, in words, the first cause
  /// first; empty when all stopped as asked. `tell` hears of processes that let it wait, while it waits.
  std::vector<std::string> stop(std::chrono::seconds patience = std::chrono::seconds(20),
                                const std::function<void(const std::string&)>& tell = {});

  const std::vector<State>& processes() const { return processes_; }

  /// True when none runs and none will come back.
  bool all_stopped() const;

  /// True when a process does not accept its configuration; poll() has reported which and why.
  bool refused() const;

 private:
  void spawn(State& state);
  bool reap(State& state);
  struct Stopping;
  static std::string end_of(const State& state);
  bool wait_for_all(std::chrono::seconds patience, Stopping& stopping);
  void stop_stage(std::chrono::seconds patience, Stopping& stopping);

  std::vector<State> processes_;
};

}  // namespace lcmslam
