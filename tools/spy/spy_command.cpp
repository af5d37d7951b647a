#include <sys/ioctl.h>
#include <unistd.h>
#include <chrono>
#include <iostream>
#include <mutex>
#include <thread>

#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/above_zero.hpp"
#include "tools/commands.hpp"
#include "tools/parse_command.hpp"
#include "tools/spy/bus_listener.hpp"
#include "tools/spy/spy_report.hpp"

namespace lcmslam {
namespace {

struct SpyOptions {
  std::string lcm_url;
  bool once = false, json = false;
  double seconds = 2;
};

/// Counts in a thread of its own, so that drawing never delays receiving.
class Spy {
 public:
  explicit Spy(const std::string& lcm_url)
      : lcm_url_(lcm_url),
        listener_(lcm_url, ".*",
                  [this](const std::string& channel, const std::uint8_t* data, std::size_t size) {
                    const std::lock_guard<std::mutex> lock(mutex_);
                    statistics_.add(channel, data, size, now());
                  }),
        thread_([this] { listener_.run([this] { return stop_.load(); }); }) {}
  ~Spy() { finish(); }
  Spy(const Spy&) = delete;
  Spy& operator=(const Spy&) = delete;

  /// Listens no more; what had come is counted.
  void finish() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  double now() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

  SpyReport report() const {
    SpyReport report;
    report.lcm_url = lcm_url_;
    report.socket = listener_.socket();
    report.refusals = listener_.refusals();
    report.dropped = listener_.dropped();
    const std::lock_guard<std::mutex> lock(mutex_);
    report.seconds = now();
    report.channels = statistics_.channels(report.seconds);
    report.left_out = statistics_.left_out();
    return report;
  }

 private:
  const std::string lcm_url_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  BusStatistics statistics_;
  mutable std::mutex mutex_;
  std::atomic<bool> stop_{false};
  BusListener listener_;
  std::thread thread_;
};

/// False when a signal ended the wait.
bool wait_until(const Spy& spy, double time) {
  while (!stop_requested() && spy.now() < time) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return !stop_requested();
}

void draw(const SpyReport& report) {
  winsize size{};
  ioctl(STDOUT_FILENO, TIOCGWINSZ, &size);
  const std::string text = spy_text(report);
  const std::string fitted =
      size.ws_row > 2 && size.ws_col > 0 ? fit_to_screen(text, size.ws_row, size.ws_col) : text;
  std::string screen = "\x1b[H";  // to the top; each line overwrites the old one: nothing flickers
  for (const char c : fitted) screen += c == '\n' ? std::string("\x1b[K\n") : std::string(1, c);
  std::cout << screen << "\x1b[J" << std::flush;
}

void show_live(Spy& spy, bool as_json) {
  const bool screen = !as_json && isatty(STDOUT_FILENO) != 0;
  if (screen) std::cout << "\x1b[2J";
  double time = 0;
  while (wait_until(spy, time += 1)) {
    const SpyReport report = spy.report();
    if (screen)
      draw(report);
    else
      std::cout << (as_json ? spy_json(report) : spy_text(report) + "\n") << std::flush;
    if (!std::cout) return;  // the reader of a pipe went away
  }
}

}  // namespace

int spy_command(int argc, char** argv) {
  SpyOptions options;
  CLI::App app{"Shows what goes over the bus: a table that is drawn anew every second.", "lcmslam spy"};
  app.add_option("--lcm-url", options.lcm_url,
                 "LCM provider; default LCM_DEFAULT_URL or " + std::string(default_lcm_url));
  app.add_flag("--once", options.once, "listen for a while, print one table and end");
  app.add_option("--seconds", options.seconds, "how long --once listens (ended earlier by Ctrl-C); default 2")
      ->check(above_zero())
      ->needs("--once");
  app.add_flag("--json", options.json, "one line of JSON instead of a table");
  app.footer(
      "gaps: messages missing by the senders' numbering, '-' where senders do not number; jitter: standard\n"
      "deviation of the intervals over 5 s; bad: messages that do not decode.");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (options.lcm_url.empty()) options.lcm_url = lcm_url_from_environment();

  install_stop_signals(0);
  Spy spy(options.lcm_url);
  if (!options.once) {
    show_live(spy, options.json);
    return 0;
  }
  std::cerr << "listens to " << options.lcm_url << "\n";
  wait_until(spy, options.seconds);
  spy.finish();
  const SpyReport report = spy.report();
  std::cout << (options.json ? spy_json(report) : spy_text(report)) << std::flush;
  return 0;
}

}  // namespace lcmslam
