#include "tools/study/faults/fault.hpp"

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

struct KindFacts {
  FaultKind kind;
  const char* name;
  double seconds;
};

constexpr KindFacts kinds[] = {{FaultKind::stamp_ahead, "stamp ahead", 0},
                               {FaultKind::black, "black", 3},
                               {FaultKind::killed, "killed", 0},
                               {FaultKind::stranger, "stranger", 3},
                               {FaultKind::late, "late", 3},
                               {FaultKind::paused, "paused", 6},
                               {FaultKind::other_camera, "other camera", 3},
                               {FaultKind::garbage, "garbage", 3},
                               {FaultKind::disk_full, "disk full", 4},
                               {FaultKind::stamp_zero, "stamp zero", 0},
                               {FaultKind::doubled, "doubled", 3},
                               {FaultKind::silent, "silent", 4},
                               {FaultKind::slip, "slip", 1},
                               {FaultKind::busy, "busy", 5},
                               {FaultKind::clock_jump, "clock jump", 0}};

constexpr const char* processes[] = {"fastslam", "icp", "surf", "odometry", "map-server"};
constexpr const char* all_processes[] = {"fastslam", "icp", "surf", "odometry", "map-server", "camera"};

}  // namespace

const char* to_string(FaultKind kind) {
  for (const KindFacts& facts : kinds)
    if (facts.kind == kind) return facts.name;
  return "";
}

std::vector<Fault> fault_schedule(std::uint64_t seed, double seconds, const FaultScheduleSettings& settings) {
  std::vector<Fault> faults;
  Random random(seed);
  // Consecutive runs go on where the last one ended.
  const auto per_run = static_cast<std::uint64_t>(
      std::max(0.0, (seconds - settings.first - settings.undisturbed) / settings.apart + 1));
  for (std::uint64_t i = 0; i < per_run; ++i) {
    const std::uint64_t number = seed * per_run + i;
    const KindFacts& facts = kinds[number % std::size(kinds)];
    Fault fault{facts.kind, settings.first + settings.apart * static_cast<double>(i), facts.seconds, ""};
    fault.at += random.uniform(0, 1);
    if (facts.kind == FaultKind::killed || facts.kind == FaultKind::paused)
      fault.process = processes[(number / std::size(kinds) + seed) % std::size(processes)];
    faults.push_back(fault);
  }
  return faults;
}

std::vector<Fault> kill_schedule(std::uint64_t seed, double seconds, double apart) {
  std::vector<Fault> faults;
  Random random(seed);
  for (double at = apart; at + apart <= seconds; at += apart) {
    const auto process = static_cast<std::size_t>(random.uniform(0, std::size(all_processes)));
    faults.push_back({FaultKind::killed, at + random.uniform(-2, 2), 0, all_processes[process]});
  }
  return faults;
}

}  // namespace lcmslam
