#include "tools/launch/supervisor.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace lcmslam {
namespace {

constexpr std::chrono::seconds longest_backoff{30};
constexpr std::chrono::milliseconds poll_period{20};
constexpr int wrong_configuration = 2;  // exit code, see run_process()

std::string describe_exit(int status) {
  if (WIFSIGNALED(status))
    return "signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return "exit " + std::to_string(WEXITSTATUS(status));
}

/// The last line of a log, without time and level in front: what a process said of its end.
std::string last_words(const std::filesystem::path& file) {
  std::ifstream text(file);
  std::string last;
  for (std::string line; std::getline(text, line);)
    if (!line.empty()) last = line;
  const std::string level = "[error] ";
  const std::size_t at = last.find(level);
  return at == std::string::npos ? last : last.substr(at + level.size());
}

/// Runs in the child between fork and exec: only async-signal-safe calls.
[[noreturn]] void become(char* const* argv, int log, pid_t parent) {
  setpgid(0, 0);  // Ctrl-C goes to the supervisor alone
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);  // it died in between
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  const int input = open("/dev/null", O_RDONLY);
  dup2(input, STDIN_FILENO);
  execv(argv[0], argv);
  const char message[] = "cannot be executed\n";
  if (write(STDERR_FILENO, message, sizeof message - 1) < 0) _exit(126);
  _exit(127);
}

}  // namespace

/// "exit 1: maps are not saved: ..."
std::string Supervisor::end_of(const State& state) {
  const std::string words = last_words(state.spec.log);
  return state.last_exit + (words.empty() ? "" : ": " + words);
}

void Supervisor::start(const ProcessSpec& spec) {
  if (access(spec.arguments.front().c_str(), X_OK) != 0)
    throw std::runtime_error(spec.arguments.front() + " cannot be executed: " + std::strerror(errno));
  processes_.push_back({});
  processes_.back().spec = spec;
  spawn(processes_.back());
}

void Supervisor::spawn(State& state) {
  const int log = open(state.spec.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0) throw std::runtime_error(state.spec.log.string() + ": " + std::strerror(errno));
  std::vector<char*> argv;
  for (auto& argument : state.spec.arguments) argv.push_back(argument.data());
  std::string on_restart = state.spec.on_restart + std::to_string(state.starts);
  if (state.starts > 0 && !state.spec.on_restart.empty()) argv.push_back(on_restart.data());
  argv.push_back(nullptr);

  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) become(argv.data(), log, parent);
  close(log);
  if (pid < 0) throw std::runtime_error("fork: " + std::string(std::strerror(errno)));
  state.pid = pid;
  state.started = Clock::now();
  ++state.starts;
}

bool Supervisor::reap(State& state) {
  int status = 0;
  if (state.pid == 0 || waitpid(state.pid, &status, WNOHANG) != state.pid) return false;
  state.pid = 0;
  state.last_exit = describe_exit(status);
  state.refused = WIFEXITED(status) && WEXITSTATUS(status) == wrong_configuration;
  state.failed = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
  return true;
}

std::vector<std::string> Supervisor::poll() {
  std::vector<std::string> events;
  for (State& state : processes_) {
    if (reap(state)) {
      std::string event = state.spec.name + " ended: " + state.last_exit;
      if (state.refused) {
        event += ": " + last_words(state.spec.log);
      } else if (state.spec.restart && state.failed) {  // what stopped as asked stays so
        if (Clock::now() - state.started > longest_backoff) state.backoff = std::chrono::seconds(1);
        state.restart_at = Clock::now() + state.backoff;
        event += ", restarts in " + std::to_string(state.backoff.count()) + " s";
        state.backoff = std::min(2 * state.backoff, longest_backoff);
      }
      events.push_back(event);
    }
    const bool comes_back = state.failed && state.spec.restart && !state.refused;
    if (state.pid == 0 && comes_back && Clock::now() >= state.restart_at) {
      spawn(state);
      events.push_back(state.spec.name + " restarted");
    }
  }
  return events;
}

bool Supervisor::all_stopped() const {
  return std::none_of(processes_.begin(), processes_.end(), [](const State& state) {
    return state.pid != 0 || (state.failed && state.spec.restart);
  });
}

bool Supervisor::refused() const {
  return std::any_of(processes_.begin(), processes_.end(), [](const State& state) { return state.refused; });
}

struct Supervisor::Stopping {
  std::vector<std::string> problems;
  std::function<void(const std::string&)> tell;
  bool with_last = false;

  bool concerns(const State& state) const { return state.pid != 0 && (with_last || !state.spec.stop_last); }
};

std::vector<std::string> Supervisor::stop(std::chrono::seconds patience,
                                          const std::function<void(const std::string&)>& tell) {
  Stopping stopping;
  stopping.tell = tell;
  for (const State& state : processes_)
    if (state.pid == 0 && state.failed)
      stopping.problems.push_back(state.spec.name + " was not running any more: " + end_of(state));
  stop_stage(patience, stopping);
  stopping.with_last = true;
  stop_stage(patience, stopping);
  for (State& state : processes_) state.failed = false;  // told
  return stopping.problems;
}

void Supervisor::stop_stage(std::chrono::seconds patience, Stopping& stopping) {
  const auto less_patience = std::min(patience, std::chrono::seconds(5));
  const std::pair<int, std::chrono::seconds> steps[] = {
      {SIGINT, patience}, {SIGTERM, less_patience}, {SIGKILL, std::chrono::seconds(5)}};
  std::chrono::seconds waited{0};
  for (const auto& [signal, wait] : steps) {
    for (State& state : processes_) {
      if (!stopping.concerns(state)) continue;
      kill(state.pid, signal);
      state.killed = signal == SIGKILL;
      if (signal == SIGTERM && stopping.tell)
        stopping.tell(state.spec.name + " has not stopped for " + std::to_string(waited.count()) +
                      " s and is told again");
      if (signal == SIGKILL)
        stopping.problems.push_back(state.spec.name + " did not stop within " +
                                    std::to_string(waited.count()) +
                                    " s and was killed: what it had not yet told is lost");
    }
    if (wait_for_all(wait, stopping)) break;
    waited += wait;
  }
}

/// Waits for the processes of this stage; false when one still runs after the time.
bool Supervisor::wait_for_all(std::chrono::seconds patience, Stopping& stopping) {
  const auto begin = Clock::now();
  auto next_word = begin + std::chrono::seconds(2);
  while (true) {
    std::string awaited;
    for (State& state : processes_) {
      const bool killed = state.killed;
      if (reap(state) && state.failed && !killed)
        stopping.problems.push_back(state.spec.name + " failed: " + end_of(state));
      if (stopping.concerns(state)) awaited += " " + state.spec.name;
    }
    const auto now = Clock::now();
    if (awaited.empty()) return true;
    if (now >= begin + patience) return false;
    if (now >= next_word && stopping.tell) {
      stopping.tell("waits for" + awaited);
      next_word = now + std::chrono::seconds(5);
    }
    std::this_thread::sleep_for(poll_period);
  }
}

}  // namespace lcmslam
