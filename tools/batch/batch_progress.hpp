#pragma once
// How far a run is, for whoever waits.

#include <cstdint>
#include <iosfwd>
#include <string>

namespace lcmslam {

/// "   12 s  mapping  frame 30/120  36 s left"; without what is left until the first frame is done.
std::string format_progress(double elapsed, std::int64_t frame, std::int64_t frames);

/// In a terminal a line that overwrites itself every second, elsewhere a line of its own every ten seconds.
class ProgressLine {
 public:
  ProgressLine(std::ostream& out, bool terminal) : out_(out), terminal_(terminal) {}

  /// `elapsed` s since the begin.
  void show(double elapsed, std::int64_t frame, std::int64_t frames);
  /// What is printed next begins a line.
  void clear();

 private:
  std::ostream& out_;
  bool terminal_;
  double shown_ = 0;
};

}  // namespace lcmslam
