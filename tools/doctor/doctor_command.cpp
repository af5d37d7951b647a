#include <unistd.h>
#include <cstdlib>
#include <iostream>

#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/private_bus.hpp>
#include <lcmslam/runtime/terminal_colours.hpp>
#include "tools/commands.hpp"
#include "tools/doctor/checks.hpp"
#include "tools/doctor/clock_checks.hpp"
#include "tools/doctor/graph_traffic.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// Applies what can be applied; true when something was.
bool mend(const std::vector<Finding>& findings) {
  bool mended = false;
  for (const Finding& finding : findings) {
    if (finding.cure.empty() || finding.cure.find("NETWORK_CARD") != std::string::npos) continue;
    std::string command = finding.cure;
    const std::string sudo = "sudo ";
    const std::size_t at = command.find(sudo);
    if (at != std::string::npos) command.replace(at, sudo.size(), geteuid() == 0 ? "" : "sudo -n ");
    std::cout << "runs: " << command << std::endl;
    if (std::system(command.c_str()) == 0)
      mended = true;
    else
      std::cout << "  that is not permitted here; run it yourself: " << finding.cure << "\n";
  }
  return mended;
}

}  // namespace

int doctor_command(int argc, char** argv) {
  DoctorOptions options;
  bool fix = false, private_bus = false;
  std::string config, log;
  double drive = 0;
  std::vector<std::string> overrides;
  CLI::App app{"Looks for what makes LCM lose messages on this machine, and says what mends it.",
               "lcmslam doctor"};
  app.add_option("--lcm-url", options.lcm_url, "LCM provider");
  auto* graph =
      app.add_option("config", config, "configuration whose graph is meant; its images are measured")
          ->check(CLI::ExistingFile);
  app.add_option("--set", overrides, "override: section.key=value")->needs(graph);
  const auto* largest =
      app.add_option("--largest", options.traffic.largest,
                     "bytes of the largest message, without a configuration 300000: VGA with depth")
          ->check(CLI::Range(1000, 100'000'000));
  const auto* rate = app.add_option("--rate", options.traffic.rate, "Hz of those, without a configuration 30")
                         ->check(CLI::Range(0.1, 1000.0));
  app.add_option("--seconds", options.seconds, "how long the bus is tried")->check(CLI::Range(0.1, 3600.0));
  app.add_option("--log", log,
                 "only whether odometry and camera of this log are stamped by one clock, from their motion")
      ->check(CLI::ExistingFile);
  app.add_option("--drive", drive,
                 "s that a running graph is listened to while the robot drives, for the same")
      ->check(CLI::Range(1.0, 3600.0));
  app.add_flag("--fix", fix, "run the lines that mend what was found, as root or by sudo");
  app.add_flag("--private-bus", private_bus, "look at a private network namespace instead");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  const bool colours = wants_colours(STDOUT_FILENO);
  if (!log.empty()) {
    const std::vector<Finding> findings{check_odometry_clock(log)};
    std::cout << log << "\n" << format_findings(findings, true, colours);
    return worst(findings) >= Finding::Level::warning ? 1 : 0;
  }
  if (options.lcm_url.empty()) options.lcm_url = lcm_url_from_environment();
  if (private_bus && !enter_private_bus()) {
    std::cerr << "lcmslam doctor: this machine permits no private network namespace\n";
    return 1;
  }
  if (!config.empty()) {
    const GraphTraffic given = options.traffic;
    options.traffic = graph_traffic(config, overrides);
    if (largest->count() > 0) options.traffic.largest = given.largest;
    if (rate->count() > 0) options.traffic.rate = given.rate;
  }
  if (largest->count() > 0) options.traffic.origin = "given";
  std::cout << options.lcm_url << std::endl;
  auto findings = examine(options);
  if (drive > 0 && findings.front().level != Finding::Level::failure)
    findings.push_back(check_odometry_clock_live(options.lcm_url, drive));
  std::cout << format_findings(findings, true, colours);
  if (fix && mend(findings)) {
    findings = examine(options);
    std::cout << "after mending:\n" << format_findings(findings, true, colours);
  }
  return worst(findings) >= Finding::Level::warning ? 1 : 0;
}

}  // namespace lcmslam
