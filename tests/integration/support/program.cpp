#include "tests/integration/support/program.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "tests/integration/support/environment.hpp"

namespace lcmslam::integration {
namespace {

[[noreturn]] void become(char* const* argv, int output, const char* folder) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  const int input = open("/dev/null", O_RDONLY);
  dup2(input, STDIN_FILENO);
  if (chdir(folder) == 0) execvp(argv[0], argv);
  _exit(127);
}

/// Of a process in /proc: state and parent, from behind its name, which itself may hold spaces.
struct ProcessFacts {
  char state = 'Z';
  pid_t parent = 0;
};

ProcessFacts facts_of(pid_t pid) {
  ProcessFacts facts;
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string stat;
  if (!std::getline(file, stat)) return facts;
  std::istringstream(stat.substr(stat.rfind(')') + 1)) >> facts.state >> facts.parent;
  return facts;
}

/// Children, their children and so on.
std::vector<pid_t> descendants(pid_t ancestor) {
  std::multimap<pid_t, pid_t> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    if (pid > 0) children.emplace(facts_of(pid).parent, pid);
  }
  std::vector<pid_t> found{ancestor};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto [first, last] = children.equal_range(found[i]);
    for (auto child = first; child != last; ++child) found.push_back(child->second);
  }
  found.erase(found.begin());
  return found;
}

}  // namespace

std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  const std::filesystem::path built = program_folder() / name;
  return std::filesystem::exists(built) ? built.string() : name;
}

Program::Program(std::vector<std::string> arguments, const std::filesystem::path& folder) {
  arguments.front() = find_program(arguments.front());
  file_ = std::filesystem::temp_directory_path() / "lcmslam-output-XXXXXX";
  const int output = mkostemp(file_.data(), O_CLOEXEC | O_APPEND);
  if (output < 0) throw std::runtime_error(file_ + ": cannot be made");
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) become(argv.data(), output, folder.c_str());
  close(output);
  if (pid_ < 0) throw std::runtime_error("fork failed");
}

Program::~Program() {
  if (!ending_.ended) {
    kill(pid_, SIGSTOP);  // it starts no more
    const std::vector<pid_t> started = descendants(pid_);
    kill(-pid_, SIGKILL);
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    for (const pid_t pid : started) kill(pid, SIGKILL);
    wait_until([&] { return std::none_of(started.begin(), started.end(), process_exists); }, 10);
  }
  std::remove(file_.c_str());
}

std::string Program::output() const {
  std::ifstream file(file_);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void Program::send(int signal) const {
  if (!ending_.ended) kill(pid_, signal);
}

Ending Program::poll() {
  int status = 0;
  if (ending_.ended || waitpid(pid_, &status, WNOHANG) != pid_) return ending_;
  ending_.ended = true;
  if (WIFEXITED(status)) ending_.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) ending_.signal = WTERMSIG(status);
  return ending_;
}

Ending Program::wait(double seconds) {
  wait_until([this] { return poll().ended; }, seconds);
  return ending_;
}

Result run(std::vector<std::string> arguments, double seconds) {
  Program program(std::move(arguments));
  const Ending ending = program.wait(seconds);
  return {ending.exit_code, program.output()};
}

bool process_exists(pid_t pid) {
  return facts_of(pid).state != 'Z';
}

}  // namespace lcmslam::integration
