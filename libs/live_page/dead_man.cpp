#include <lcmslam/live_page/dead_man.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lcmslam {

Drive DeadMan::drive(Operator who, const Drive& wanted, double now) {
  if (!std::isfinite(wanted.linear) || !std::isfinite(wanted.angular))
    throw std::invalid_argument("linear and angular must be numbers from -1 to 1");
  const bool takes_over = driver_ != 0 && driver_ != who;
  heard_ = now;
  const Drive bounded = {std::clamp(wanted.linear, -1.0, 1.0), std::clamp(wanted.angular, -1.0, 1.0)};
  driver_ = bounded.stops() ? 0 : who;
  return takes_over ? Drive{} : bounded;
}

std::optional<Drive> DeadMan::gone(Operator who) {
  if (driver_ == 0 || driver_ != who) return std::nullopt;
  driver_ = 0;
  return Drive{};
}

std::optional<Drive> DeadMan::silent(double now) {
  if (driver_ == 0 || now - heard_ < silence_) return std::nullopt;
  driver_ = 0;
  return Drive{};
}

}  // namespace lcmslam
