#pragma once
// Section `launch`.

#include <map>
#include <string>
#include <vector>

#include <lcmslam/runtime/options.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// How one process is started.
struct LaunchedProcess {
  std::string host;
  std::vector<std::string> after, environment;
  std::vector<double> cpus;
  int nice = 0;
  double memory = 0;  // MB

  void describe(SettingsVisitor& s);
};

struct LaunchSettings {
  std::vector<std::string> processes = process_names();
  bool restart = true;
  int restart_limit = 10;
  std::string robot, host, interface;
  int ttl = 0;
  double clock_offset = 0.005;  // s
  double log_size = 20;         // MB
  int log_files = 3;
  std::map<std::string, LaunchedProcess> of;  ///< by process

  LaunchSettings();
  void describe(SettingsVisitor& s);

  /// Where a process runs; empty: wherever launch is started.
  std::string host_of(const std::string& process) const;
  /// Every host that is named, each once.
  std::vector<std::string> hosts() const;

 private:
  void check(SettingsVisitor& s) const;
};

/// Names in a circle of `after`, "a, b, a"; empty: there is none.
std::string circle_of(const LaunchSettings& settings);

}  // namespace lcmslam
