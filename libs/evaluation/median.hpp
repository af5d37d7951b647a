#pragma once
// The middle of a few values.

#include <algorithm>
#include <limits>
#include <vector>

namespace lcmslam {

/// NaN of nothing; the mean of both middle values of an even number.
inline double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

}  // namespace lcmslam
