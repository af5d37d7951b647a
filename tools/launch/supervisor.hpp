#pragma once
// Starts processes, notices their end, restarts them, stops them all. No process outlives the
// supervisor, not even when it is killed with -9 (the kernel then sends them SIGTERM).

#include <sys/types.h>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

struct ProcessSpec {
  std::string name;
  std::vector<std::string> arguments;  ///< program first
  std::filesystem::path log;           ///< its standard output and error are appended there
  bool restart = true;                 ///< when it ends by itself
  bool stop_last = false;              ///< only when the others have stopped: it keeps what they make
};

class Supervisor {
 public:
  using Clock = std::chrono::steady_clock;

  struct State {
    ProcessSpec spec;
    pid_t pid = 0;  ///< 0: does not run
    int starts = 0;
    bool refused = false;   ///< ended with exit 2: its configuration is wrong, starting it again is no use
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

  /// INT, then TERM, then KILL, each after its patience. Gives what happened, in words.
  std::vector<std::string> stop(std::chrono::seconds patience = std::chrono::seconds(20));

  const std::vector<State>& processes() const { return processes_; }

  /// True when a process does not accept its configuration; poll() has reported which and why.
  bool refused() const;

 private:
  void spawn(State& state);
  bool reap(State& state);
  bool wait_for_all(std::chrono::seconds patience, bool with_last);
  void stop_stage(bool with_last, std::chrono::seconds patience, std::vector<std::string>& events);

  std::vector<State> processes_;
};

}  // namespace lcmslam
