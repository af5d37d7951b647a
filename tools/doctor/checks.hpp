#pragma once
// What keeps LCM from working on a machine, and the line that mends it.

#include <filesystem>
#include <string>
#include <vector>

#include <lcmslam/runtime/refusals.hpp>
#include "tools/doctor/graph_traffic.hpp"

namespace lcmslam {

struct Finding {
  enum class Level { good, note, warning, failure };
  Level level = Level::good;
  std::string subject;  ///< "multicast route", ...
  std::string text;     ///< what was found, in plain words
  std::string cure;     ///< command that mends it; empty when nothing needs to be mended
};

struct DoctorOptions {
  std::string lcm_url;
  GraphTraffic traffic;                ///< size and rate of the loop-back test
  double seconds = 1;                  ///< of the loop-back test and of listening
  std::vector<std::string> processes;  ///< that are about to start: the same ones heard already are a failure
  std::filesystem::path folder = ".";  ///< where maps and logs go
  std::string interface;               ///< that packets must leave through; empty: any
};

/// `interface`: the one that packets must leave through; empty: any.
Finding check_route(const std::string& lcm_url, const std::string& interface = "");
Finding check_receive_buffer(const std::string& lcm_url, const GraphTraffic& traffic);
/// Sends to itself at the graph's size and rate. Needs a route.
Finding check_loop_back(const DoctorOptions& options);
/// Listens for what others send, for 1.5 s at least: STATUS comes at 1 Hz. One whose time is more than a
/// minute from now is played from a log and no rival, but what comes with it is worth a warning; nor is a
/// process whose last word was that it stops.
Finding check_senders(const DoctorOptions& options);
/// Whose packets the URL and LCMSLAM_BUS_ALLOW let in.
Finding check_sources(const std::string& lcm_url);
/// The same as check_senders(), and what was refused meanwhile, here and by a graph that runs.
std::vector<Finding> check_traffic(const DoctorOptions& options);
/// `root`: of the file system's tree below which sys/devices/system/cpu is looked for.
/// Whether the first images of the graph's own source fit their calibration; nothing where it has none.
std::vector<Finding> check_images(const GraphTraffic& traffic);
Finding check_governor(const std::filesystem::path& root = "/");
Finding check_disk(const std::filesystem::path& folder);

/// All of them, in this order; what needs a route only where there is one.
std::vector<Finding> examine(const DoctorOptions& options);

/// Two graphs on one bus take each other's measurements for their own.
inline bool is_rival_graph(const Finding& finding) {
  return finding.subject == "other senders" && finding.level == Finding::Level::failure;
}

Finding::Level worst(const std::vector<Finding>& findings);
/// Lines to print; good ones only when `all`.
std::string format_findings(const std::vector<Finding>& findings, bool all, bool colours = false);

}  // namespace lcmslam
