#pragma once
#include <limits>
#include <string>

namespace lcmslam {

/// Closed interval that a number must lie in.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  bool holds(double number) const { return number >= low && number <= high; }
};

/// "a number from 0 to 1", "a whole number of at least 1", ...
std::string range_text(const std::string& kind, const Range& range);

}  // namespace lcmslam
