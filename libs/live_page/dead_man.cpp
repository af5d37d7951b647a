#include <lcmslam/live_page/dead_man.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace lcmslam {

Drive DeadMan::drive(Operator who, const Drive& wanted, double now) {
  if (!std::isfinite(wanted.linear) || !std::isfinite(wanted.angular))
    throw std::invalid_argument("linear and angular must be numbers from -1 to 1");
  const Drive bounded = {std::clamp(wanted.linear, -1.0, 1.0), std::clamp(wanted.angular, -1.0, 1.0)};
  if (who == ousted_) {
    const bool goes_on = !bounded.stops() && now - ousted_heard_ < silence_;
    ousted_heard_ = now;
    if (goes_on) throw std::runtime_error("another operator has taken over");
    ousted_ = 0;
  }
  const bool takes_over = driver_ != 0 && driver_ != who;
  if (takes_over && !bounded.stops()) ousted_ = driver_, ousted_heard_ = now;
  heard_ = now;
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
