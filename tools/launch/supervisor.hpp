#pragma once
// Starts processes when those that they need are ready, notices their end, restarts them, stops them all. No
// process outlives the supervisor, not even when it is killed with -9 (the kernel then sends them SIGTERM).

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tools/launch/limits.hpp"

namespace lcmslam {

struct ProcessSpec {
  std::string name;
  std::vector<std::string> arguments;      ///< program first
  std::filesystem::path log;               ///< its standard output and error are appended there
  bool restart = true;                     ///< when it ends and was not asked to (its exit code is not 0)
  bool stop_last = false;                  ///< only when the others have stopped: it keeps what they make
  std::string on_restart{};                ///< argument that a restart adds, with its number behind it
  std::vector<std::string> after{};        ///< names of those that must be ready before it starts
  int restart_limit = 0;                   ///< restarts in a row, each soon after the last; 0: no limit
  std::vector<std::string> environment{};  ///< NAME=VALUE
  ProcessLimits limits{};
  std::uintmax_t log_bytes = 0;  ///< after which the log begins anew; 0: never
  int log_files = 1;
  /// Who ran so long did not fail to start: it comes back at once.
  std::chrono::milliseconds long_run{30'000};
};

class Supervisor {
 public:
  using Clock = std::chrono::steady_clock;

  struct State {
    ProcessSpec spec;
    pid_t pid = 0;  ///< 0: does not run
    int starts = 0;
    bool was_ready = false;  ///< since the supervisor began
    bool wrong = false;      ///< ended with exit 2: it takes its configuration not, or not now
    bool refused = false;    ///< so, and never was ready: starting it again is no use
    bool failed = false;     ///< its last end was not that of a process that stops as asked
    bool waits = false;      ///< for others to be ready: it was never started
    bool asked = false;      ///< to restart
    bool given_up = false;   ///< it ended too often in a row
    int in_a_row = 0;        ///< restarts that came soon after the last
    bool killed = false;     ///< by this supervisor, because it did not stop
    int ended_by = 0;        ///< signal; 0: it ended by itself, or did not end yet
    std::string last_exit;   ///< "exit 1", "signal 9 (Killed)"; empty before the first
    Clock::time_point started{};
    Clock::time_point restart_at{};
  };

  ~Supervisor() { stop(); }

  /// At once, or when all that it needs are ready. Throws std::runtime_error when the program cannot be
  /// started.
  void start(const ProcessSpec& spec);

  /// A process, here or on another host, says that it runs.
  void note_ready(const std::string& name);

  /// Ends a process as asked and starts it again; one that was given up too. Gives why not, in words: the
  /// name is not known here, it waits for others, it cannot be started. Empty: it starts again.
  std::string restart(const std::string& name);

  /// Collects what ended and restarts it in time; gives what happened, in words. What cannot be started now
  /// (the machine is short of processes, say) is tried again as what ended: the others go on.
  std::vector<std::string> poll();

  /// INT, then TERM, then KILL, each after its patience. Gives what went wrong, in words, the first cause
  /// first; empty when all stopped as asked. `tell` hears of processes that let it wait, while it waits.
  std::vector<std::string> stop(std::chrono::seconds patience = std::chrono::seconds(20),
                                const std::function<void(const std::string&)>& tell = {});

  const std::vector<State>& processes() const { return processes_; }

  /// Names that a process still waits for.
  std::vector<std::string> lacking(const State& state) const;
  /// "odometry waits for surf"
  std::string wait_of(const State& state) const;

  /// True when none runs and none will come back.
  bool all_stopped() const;

  /// True when a process does not accept its configuration; poll() has reported which and why.
  bool refused() const;

 private:
  void spawn(State& state);
  std::string spawn_again(State& state);
  static std::string schedule(State& state);
  bool reap(State& state);
  void rotate_logs();
  static bool comes_back(const State& state);
  static bool stopped_at_its_begin(const State& state);
  struct Stopping;
  static std::string end_of(const State& state);
  bool wait_for_all(std::chrono::seconds patience, Stopping& stopping);
  void stop_stage(std::chrono::seconds patience, Stopping& stopping);

  std::vector<State> processes_;
  std::set<std::string> ready_;
  Clock::time_point logs_looked_at_{};
};

}  // namespace lcmslam
