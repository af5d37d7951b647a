#include <lcmslam/odometry/source_choice.hpp>

#include <algorithm>

namespace lcmslam {

SourceChoice::SourceChoice(double patience) : patience_(1e6 * patience) {}

void SourceChoice::heard(OdometrySource source, Utime utime) {
  if (chosen_) return;
  Utime& since = spoken_since_.try_emplace(source, utime).first->second;
  since = std::min(since, utime);  // time began anew, or the first stamp was wrong
  const double spoken = static_cast<double>(utime) - static_cast<double>(since);  // stamps may be any number
  if (source == OdometrySource::wheels || spoken >= patience_) chosen_ = spoken_since_.begin()->first;
}

}  // namespace lcmslam
