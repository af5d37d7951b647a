#include "procs/map-server/page/bus_log.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string>

namespace lcmslam {
namespace {

/// Runs in the child: only async-signal-safe calls. The logger ends with this process, and holds none of its
/// ports. On the bus of LCM_DEFAULT_URL, which is this process's (runtime/process.cpp). Why it cannot be
/// started goes into `told`.
[[noreturn]] void become_logger(const char* file, int told) {
  prctl(PR_SET_PDEATHSIG, SIGINT);
  const int kept = fcntl(told, F_DUPFD_CLOEXEC, 3);
  dup2(kept, 3);
  fcntl(3, F_SETFD, FD_CLOEXEC);
  close_range(4, ~0U, 0);
  execlp("lcm-logger", "lcm-logger", "--quiet", file, nullptr);
  const int error = errno;
  if (write(3, &error, sizeof(error)) < 0) _exit(126);
  _exit(127);
}

}  // namespace

BusLog::~BusLog() {
  if (is_running()) stop();
}

std::filesystem::path BusLog::start() {
  if (is_running()) throw std::runtime_error("a log is being written already: " + file_.string());
  std::filesystem::create_directories(folder_);
  int number = 1;
  do {
    file_ = folder_ / ("log-" + std::to_string(number++) + ".lcmlog");
  } while (std::filesystem::exists(file_));
  const std::string name = file_.string();
  int told[2];
  if (pipe2(told, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  logger_ = fork();
  if (logger_ == 0) become_logger(name.c_str(), told[1]);
  int error = logger_ < 0 ? errno : 0;
  close(told[1]);
  if (read(told[0], &error, sizeof(error)) < 0) error = errno;  // nothing is read once the logger runs
  close(told[0]);
  if (error == 0) return file_;
  if (logger_ > 0) waitpid(logger_, nullptr, 0);
  logger_ = 0;
  throw std::runtime_error(std::string("lcm-logger cannot be started: ") + std::strerror(error) +
                           " (Debian's package liblcm-bin has it)");
}

std::filesystem::path BusLog::stop() {
  if (logger_ == 0) throw std::runtime_error("no log is being written");
  if (!is_running())
    throw std::runtime_error("lcm-logger had ended by itself; " + file_.string() + " may lack something");
  kill(logger_, SIGINT);  // it writes what it has
  waitpid(logger_, nullptr, 0);
  logger_ = 0;
  return file_;
}

bool BusLog::is_running() {
  if (logger_ == 0) return false;
  if (waitpid(logger_, nullptr, WNOHANG) == 0) return true;
  logger_ = 0;
  return false;
}

}  // namespace lcmslam
