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

std::string last_line(const std::filesystem::path& file) {
  std::ifstream text(file);
  std::string last;
  for (std::string line; std::getline(text, line);)
    if (!line.empty()) last = line;
  return last;
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
  return true;
}

std::vector<std::string> Supervisor::poll() {
  std::vector<std::string> events;
  for (State& state : processes_) {
    if (reap(state)) {
      std::string event = state.spec.name + " ended: " + state.last_exit;
      if (state.refused) {
        event += ": " + last_line(state.spec.log);
      } else if (state.spec.restart) {
        if (Clock::now() - state.started > longest_backoff) state.backoff = std::chrono::seconds(1);
        state.restart_at = Clock::now() + state.backoff;
        event += ", restarts in " + std::to_string(state.backoff.count()) + " s";
        state.backoff = std::min(2 * state.backoff, longest_backoff);
      }
      events.push_back(event);
    }
    if (state.pid == 0 && state.spec.restart && !state.refused && Clock::now() >= state.restart_at) {
      spawn(state);
      events.push_back(state.spec.name + " restarted");
    }
  }
  return events;
}

bool Supervisor::refused() const {
  return std::any_of(processes_.begin(), processes_.end(), [](const State& state) { return state.refused; });
}

bool Supervisor::wait_for_all(std::chrono::seconds patience, bool with_last) {
  const auto deadline = Clock::now() + patience;
  while (true) {
    bool running = false;
    for (State& state : processes_) {
      reap(state);
      running = running || (state.pid != 0 && (with_last || !state.spec.stop_last));
    }
    if (!running) return true;
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(poll_period);
  }
}

std::vector<std::string> Supervisor::stop(std::chrono::seconds patience) {
  std::vector<std::string> events;
  stop_stage(false, patience, events);
  stop_stage(true, patience, events);
  return events;
}

void Supervisor::stop_stage(bool with_last, std::chrono::seconds patience, std::vector<std::string>& events) {
  const auto less_patience = std::min(patience, std::chrono::seconds(5));
  const std::pair<int, std::chrono::seconds> steps[] = {
      {SIGINT, patience}, {SIGTERM, less_patience}, {SIGKILL, std::chrono::seconds(5)}};
  for (const auto& [signal, wait] : steps) {
    for (const State& state : processes_) {
      if (state.pid == 0 || (state.spec.stop_last && !with_last)) continue;
      kill(state.pid, signal);
      if (signal != SIGINT) events.push_back(state.spec.name + " did not stop: " + strsignal(signal));
    }
    if (wait_for_all(wait, with_last)) break;
  }
}

}  // namespace lcmslam
