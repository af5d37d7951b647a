#include <lcmslam/odometry/source_choice.hpp>

#include <algorithm>

namespace lcmslam {

SourceChoice::SourceChoice(double patience) : patience_(1e6 * patience) {}

void SourceChoice::heard(OdometrySource source, Utime utime) {
  if (chosen_) return;
  Spoken& heard = spoken_.try_emplace(source, Spoken{utime}).first->second;
  ++heard.messages;
  heard.since = std::min(heard.since, utime);  // time began anew, or the first stamp was wrong
  const double spoken =
      static_cast<double>(utime) - static_cast<double>(heard.since);  // stamps may be any number
  if (source != OdometrySource::wheels && spoken < patience_) return;
  // A joystick that says once that nobody moves it is no odometry.
  chosen_ = std::find_if(spoken_.begin(), spoken_.end(), [&](const auto& known) {
              return known.first == source || known.second.messages > 1;
            })->first;
}

}  // namespace lcmslam
