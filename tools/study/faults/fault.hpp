#pragma once
// What the study of faults does to a running graph, and when.

#include <cstdint>
#include <string>
#include <vector>

namespace lcmslam {

enum class FaultKind {
  // The camera's messages.
  stamp_ahead,   ///< a frame comes again with a stamp 10 s ahead
  stamp_zero,    ///< a frame comes again with stamp 0
  black,         ///< black colour, no depth
  late,          ///< frames wait and come together
  doubled,       ///< each frame comes twice
  other_camera,  ///< another publisher sends old frames beside
  silent,        ///< no frame at all
  // What else the robot measures.
  slip,        ///< the wheels spin for nothing, half a metre
  clock_jump,  ///< all stamps are 100 s later from then on
  // The processes.
  killed,  ///< kill -9
  paused,  ///< SIGSTOP, then SIGCONT
  busy,    ///< others take all processors, twice over
  // Strangers.
  stranger,   ///< real messages of the graph, of another sender and older
  garbage,    ///< mutated messages, wrong fragments among them
  disk_full,  ///< the run's folder takes nothing more, and the map's file has no room within
};

const char* to_string(FaultKind kind);

struct Fault {
  FaultKind kind = FaultKind::black;
  double at = 0;        ///< s since the first frame
  double seconds = 0;   ///< how long it lasts; 0: at once
  std::string process;  ///< killed, paused: which one
};

struct FaultScheduleSettings {
  double first = 8;        ///< s: the map is undisturbed until then
  double apart = 9;        ///< s between the beginnings of two faults
  double undisturbed = 6;  ///< s at the end
};

/// Faults for a run of `seconds`: kinds and processes in an order that `seed` shuffles; runs with consecutive
/// seeds together have all of them.
std::vector<Fault> fault_schedule(std::uint64_t seed, double seconds,
                                  const FaultScheduleSettings& settings = {});

/// One process after the other killed, in an order that `seed` shuffles, a fault each `apart` s.
std::vector<Fault> kill_schedule(std::uint64_t seed, double seconds, double apart);

}  // namespace lcmslam
