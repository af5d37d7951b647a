#include "tools/log/log_selection.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

constexpr double longest_log = 1e9;  // s; larger values are utimes
constexpr double latest_time = 1e17;

void check_time(const std::optional<LogTime>& time, const char* option) {
  if (time && !(time->value >= 0 && time->value < latest_time))
    throw std::invalid_argument(fmt::format(
        "{} {}: must be seconds from the log's start, or a utime in microseconds", option, time->value));
}

}  // namespace

Utime LogTime::utime(Utime first) const {
  if (value > longest_log) return static_cast<Utime>(std::llround(value));
  return first + std::min(static_cast<Utime>(std::llround(1e6 * value)), time_between(first, INT64_MAX));
}

void LogSelection::check() const {
  check_time(from, "--from");
  check_time(to, "--to");
  const bool comparable = from && to && (from->value > longest_log) == (to->value > longest_log);
  if (comparable && from->value >= to->value)
    throw std::invalid_argument(
        fmt::format("--from {} --to {}: nothing lies between", from->value, to->value));
  for (const auto& channel : channels)
    if (without_channels.count(channel) > 0)
      throw std::invalid_argument("channel " + channel + " is asked for and left out");
}

void LogSelection::check_channels(const std::set<std::string>& in_log, const std::string& log) const {
  for (const auto* asked : {&channels, &without_channels})
    for (const auto& channel : *asked)
      if (in_log.count(channel) == 0)
        throw std::runtime_error(fmt::format("{}: has no channel '{}'; it has {}", log, channel,
                                             printable(fmt::format("{}", fmt::join(in_log, ", ")))));
}

}  // namespace lcmslam
