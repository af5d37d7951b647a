#pragma once
// The whole graph live, on a camera that the study plays, while things go wrong; what that did to poses and
// maps.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "procs/camera/camera_source.hpp"
#include "tools/study/faults/fault.hpp"
#include "tools/study/faults/fault_responses.hpp"
#include "tools/study/faults/kept_map.hpp"
#include "tools/study/faults/mapper_watch.hpp"

namespace lcmslam {

struct FaultRunSettings {
  std::string config;                  ///< of the graph; its camera is left out
  std::vector<std::string> overrides;  ///< section.key=value
  std::string lcm_url;
  std::filesystem::path folder;  ///< of the results
  std::vector<Fault> faults;     ///< by time
  std::uint64_t seed = 1;
  /// s: by the poses until then a run is laid onto the truth, with faults or without: of one that is laid by
  /// all of its poses less is left.
  double laid_until = FaultScheduleSettings().first;
  bool export_before = true;  ///< maps, before each fault, to be found again after the run
};

/// A mapper's part in a run.
struct MapperOutcome {
  double ate = 0;  ///< m
  std::size_t poses = 0, sessions = 0;
  MapperWatch::FalseTracking false_tracking;
  int maps_before = 0;     ///< saved before faults, to be found again in the files after the run
  double kept = 1;         ///< least share of the points of one of them that are
  std::string lost_after;  ///< the fault before which those were mapped
};

struct FaultRunResult {
  MapperOutcome fastslam, icp;
  Utime begun = 0;             ///< time of the first event
  KeptMap map;                 ///< in the map's file at the end
  std::vector<double> memory;  ///< bytes resident of all processes, a minute each: the largest
  std::map<std::string, std::vector<double>> memory_of;  ///< likewise, of each process
  double stop_seconds = 0;          ///< from the request to stop to the end of the last process
  std::vector<std::string> events;  ///< processes that ended or restarted
  RunRecord record;                 ///< who said what, and where they were
};

/// Throws std::runtime_error when the graph does not start.
FaultRunResult run_with_faults(CameraSource& source, const FaultRunSettings& settings);

}  // namespace lcmslam
