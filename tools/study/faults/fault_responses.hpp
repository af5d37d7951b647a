#pragma once
// What each fault of a run did: how soon somebody said so, how soon both mappers were right again, and how
// far off they were then, beside runs without faults at the same time: live no two runs are alike.

#include <optional>
#include <string>
#include <vector>

#include <lcmslam/status_t.hpp>
#include "tools/study/faults/fault.hpp"
#include "tools/study/faults/mapper_watch.hpp"

namespace lcmslam {

/// A process says that something is wrong, or is gone.
struct Alarm {
  double at = 0;  ///< s since the first frame
  std::string text;
};

/// What one STATUS tells that the one before of the same process did not; empty: nothing.
std::string trouble_told(const status_t& before, const status_t& now);

struct MapperResponse {
  std::optional<double> found;  ///< s after the fault's end: tracked within 0.1 m of the truth
  double error = 0;             ///< m, RMS from 2 s after that until the next fault
  double usual = 0, worst = 0;  ///< m, the same of all undisturbed runs together, and of the worst of them
};

struct FaultResponse {
  Fault fault;
  std::optional<double> told;  ///< s after its begin
  std::string by;              ///< who said so first
  MapperResponse fastslam, icp;
};

/// Alarms and poses of one run, by time.
struct RunRecord {
  std::vector<Alarm> alarms;
  std::vector<MapperWatch::Held> fastslam, icp;
};

std::vector<FaultResponse> fault_responses(const std::vector<Fault>& faults, const RunRecord& run,
                                           const std::vector<RunRecord>& undisturbed);

}  // namespace lcmslam
