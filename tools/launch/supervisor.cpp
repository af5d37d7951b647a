#include "tools/launch/supervisor.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "tools/launch/log_files.hpp"

namespace lcmslam {
namespace {

constexpr std::chrono::milliseconds first_pause{200}, longest_pause{30'000};  // between restarts in a row
constexpr std::chrono::seconds longest_end{20};  // of a process that is to start again
constexpr std::chrono::milliseconds poll_period{20};
constexpr int wrong_configuration = 2;  // exit code, see run_process()

std::string describe_exit(int status) {
  if (WIFSIGNALED(status))
    return "signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return "exit " + std::to_string(WEXITSTATUS(status));
}

/// Before a restart when that many came in a row, each soon after the last: none, 0.2 s, 0.4 s ... 30 s. What
/// dies once is missed until it is back; what cannot run must not keep the machine busy.
std::chrono::milliseconds pause_after(int restarts) {
  if (restarts == 0) return std::chrono::milliseconds(0);
  std::chrono::milliseconds pause = first_pause;
  for (int i = 1; i < restarts && pause < longest_pause; ++i) pause *= 2;
  return std::min(pause, longest_pause);
}

std::string describe_pause(std::chrono::milliseconds pause) {
  return pause.count() == 0 ? "restarts at once"
                            : fmt::format("restarts in {:g} s", 0.001 * static_cast<double>(pause.count()));
}

/// Runs in the child between fork and exec: only async-signal-safe calls.
[[noreturn]] void become(char* const* argv, char* const* environment, const ProcessLimits& limits, int log,
                         pid_t parent) {
  setpgid(0, 0);  // Ctrl-C goes to the supervisor alone
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);  // it died in between
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  const int input = open("/dev/null", O_RDONLY);
  dup2(input, STDIN_FILENO);
  if (const char* refused = apply(limits)) {
    if (write(STDERR_FILENO, refused, std::strlen(refused)) < 0 || write(STDERR_FILENO, "\n", 1) < 0)
      _exit(1);
    _exit(wrong_configuration);
  }
  execve(argv[0], argv, environment);
  const char message[] = "cannot be executed\n";
  if (write(STDERR_FILENO, message, sizeof message - 1) < 0) _exit(126);
  _exit(127);
}

/// This process's own, with what the specification adds or replaces.
std::vector<std::string> environment_of(const ProcessSpec& spec) {
  std::vector<std::string> all;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string text = *variable;
    const std::string name = text.substr(0, text.find('=') + 1);
    const bool replaced =
        std::any_of(spec.environment.begin(), spec.environment.end(),
                    [&](const std::string& other) { return other.compare(0, name.size(), name) == 0; });
    if (!replaced) all.push_back(text);
  }
  all.insert(all.end(), spec.environment.begin(), spec.environment.end());
  return all;
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
  State state;
  state.spec = spec;
  if (lacking(state).empty())
    spawn(state);
  else
    state.waits = true;
  processes_.push_back(std::move(state));
}

std::vector<std::string> Supervisor::lacking(const State& state) const {
  std::vector<std::string> names;
  for (const std::string& name : state.spec.after)
    if (ready_.count(name) == 0) names.push_back(name);
  return names;
}

std::string Supervisor::wait_of(const State& state) const {
  std::string text = state.spec.name + " waits for";
  for (const std::string& name : lacking(state)) text += " " + name;
  return text;
}

void Supervisor::note_ready(const std::string& name) {
  ready_.insert(name);
  for (State& state : processes_)
    if (state.spec.name == name && state.pid != 0) state.was_ready = true;
}

std::string Supervisor::restart(const std::string& name) {
  std::string names;
  for (State& state : processes_) {
    names += " " + state.spec.name;
    if (state.spec.name != name) continue;
    if (state.waits) return wait_of(state);
    if (state.pid != 0) {
      state.asked = true;
      state.restart_at = Clock::now() + longest_end;
      kill(state.pid, SIGINT);
      return "";
    }
    state.given_up = state.refused = false;
    state.in_a_row = 0;
    const std::string obstacle = spawn_again(state);
    return obstacle.empty() ? "" : std::string(name).append(" ").append(obstacle);
  }
  return "'" + name + "' is none of the processes here:" + names;
}

void Supervisor::spawn(State& state) {
  const int log = open(state.spec.log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0) throw std::runtime_error(state.spec.log.string() + ": " + std::strerror(errno));
  std::vector<char*> argv;
  for (auto& argument : state.spec.arguments) argv.push_back(argument.data());
  std::string on_restart = state.spec.on_restart + std::to_string(state.starts);
  if (state.starts > 0 && !state.spec.on_restart.empty()) argv.push_back(on_restart.data());
  argv.push_back(nullptr);

  std::vector<std::string> variables = environment_of(state.spec);
  std::vector<char*> environment;
  environment.reserve(variables.size() + 1);
  for (auto& variable : variables) environment.push_back(variable.data());
  environment.push_back(nullptr);

  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) become(argv.data(), environment.data(), state.spec.limits, log, parent);
  close(log);
  if (pid < 0) throw std::runtime_error("fork: " + std::string(std::strerror(errno)));
  state.pid = pid;
  state.started = Clock::now();
  ++state.starts;
}

/// Gives what kept it from running, and when it is tried again; empty: it runs.
std::string Supervisor::spawn_again(State& state) {
  try {
    spawn(state);
    return {};
  } catch (const std::runtime_error& error) {
    state.failed = true;
    state.last_exit = std::string("cannot be started: ") + error.what();
    return state.last_exit + schedule(state);
  }
}

/// Of what has ended: when it comes back, in words to append.
std::string Supervisor::schedule(State& state) {
  state.given_up = state.spec.restart_limit > 0 && state.in_a_row >= state.spec.restart_limit;
  if (!comes_back(state))
    return state.failed && state.given_up
               ? ", stays away after " + std::to_string(state.in_a_row) + " restarts in a row"
               : "";
  const std::chrono::milliseconds pause = pause_after(state.in_a_row++);
  state.restart_at = Clock::now() + pause;
  return ", " + describe_pause(pause);
}

bool Supervisor::reap(State& state) {
  int status = 0;
  if (state.pid == 0 || waitpid(state.pid, &status, WNOHANG) != state.pid) return false;
  state.pid = 0;
  state.last_exit = describe_exit(status);
  state.ended_by = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  state.wrong = WIFEXITED(status) && WEXITSTATUS(status) == wrong_configuration;
  // Who ran with it before lacks something else, a device say, or comes back to a file that somebody edits:
  // that must not end the graph.
  state.refused = state.wrong && !state.was_ready;
  state.failed = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
  ready_.erase(state.spec.name);
  return true;
}

/// Each process catches what asks it to stop as soon as it has anything to lose: who dies of it had not yet
/// begun.
bool Supervisor::stopped_at_its_begin(const State& state) {
  return state.ended_by == SIGINT || state.ended_by == SIGTERM;
}

/// What failed, unless starting it again is no use; what stopped as asked stays so.
bool Supervisor::comes_back(const State& state) {
  return state.failed && state.spec.restart && !state.refused && !state.given_up;
}

std::vector<std::string> Supervisor::poll() {
  std::vector<std::string> events;
  rotate_logs();
  for (State& state : processes_) {
    const std::string& name = state.spec.name;
    if (state.waits && lacking(state).empty()) {
      state.waits = false;
      const std::string obstacle = spawn_again(state);
      events.push_back(name + " " + (obstacle.empty() ? "starts" : obstacle));
    }
    if (state.asked && state.pid != 0 && Clock::now() > state.restart_at) kill(state.pid, SIGKILL);
    if (reap(state)) {
      std::string event = name + " ended: " + state.last_exit;
      const bool ran_long = Clock::now() - state.started > state.spec.long_run;
      if (ran_long) state.in_a_row = 0;
      if (state.asked)
        state.restart_at = Clock::now();
      else
        event += schedule(state);
      if (!state.asked && (state.wrong || (state.failed && state.given_up)))
        event += ": " + last_words(state.spec.log);
      events.push_back(event);
    }
    if (state.pid == 0 && (state.asked || comes_back(state)) && Clock::now() >= state.restart_at) {
      state.asked = state.given_up = state.refused = false;
      const std::string obstacle = spawn_again(state);
      events.push_back(name + " " + (obstacle.empty() ? "restarted" : obstacle));
    }
  }
  return events;
}

void Supervisor::rotate_logs() {
  if (Clock::now() < logs_looked_at_ + std::chrono::seconds(1)) return;
  logs_looked_at_ = Clock::now();
  for (const State& state : processes_)
    rotate_log(state.spec.log, state.spec.log_bytes, state.spec.log_files);
}

bool Supervisor::all_stopped() const {
  return std::none_of(processes_.begin(), processes_.end(), [](const State& state) {
    return state.pid != 0 || state.waits || state.asked || comes_back(state);
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
  for (State& state : processes_) {
    state.waits = state.asked = false;
    if (state.pid == 0 && state.failed)
      stopping.problems.push_back(state.spec.name + " was not running any more: " + end_of(state));
  }
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
      if (reap(state) && state.failed && !killed && !stopped_at_its_begin(state))
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
