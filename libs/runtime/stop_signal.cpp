#include <lcmslam/runtime/stop_signal.hpp>

#include <unistd.h>
#include <csignal>

namespace lcmslam {
namespace {

unsigned watchdog_seconds = 0;
volatile std::sig_atomic_t stop_flag = 0;

extern "C" void on_stop_signal(int) {
  stop_flag = 1;
  if (watchdog_seconds > 0) alarm(watchdog_seconds);
}

}  // namespace

void install_stop_signals(unsigned watchdog) {
  watchdog_seconds = watchdog;
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction inherited {};
  sigaction(SIGHUP, nullptr, &inherited);
  if (inherited.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of writing, not the end
}

bool stop_requested() {
  return stop_flag != 0;
}

void request_stop() {
  stop_flag = 1;
}

}  // namespace lcmslam
