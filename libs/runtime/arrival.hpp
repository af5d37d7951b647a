#pragma once
// What a message's time says of it, for every process alike. Messages may overtake each other by a little;
// one whose time lies far back comes from a log that began again, or from another run.

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

constexpr Utime late_at_most = 1'000'000;  // us; further back is another run

/// Older than the newest one, so that its time is past.
inline bool came_late(Utime utime, Utime newest) {
  return utime < newest && newest - utime < late_at_most;
}

/// The same, or the newest one's time again.
inline bool came_late_or_twice(Utime utime, Utime newest) {
  return utime <= newest && newest - utime < late_at_most;
}

enum class Arrival {
  next,   ///< goes on from the newest one
  late,   ///< came late or twice: to be left out
  jumped  ///< back to another run, or so far on that what was between is anybody's guess
};

inline Arrival arrival_of(Utime utime, Utime newest, Utime longest_gap) {
  if (came_late_or_twice(utime, newest)) return Arrival::late;
  return utime <= newest || utime - newest > longest_gap ? Arrival::jumped : Arrival::next;
}

}  // namespace lcmslam
