#include "tools/spy/arrival_rate.hpp"

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr std::size_t most_arrivals = 20'000;  // a flood must not fill the memory

}  // namespace

void ArrivalRate::add(double time, std::size_t bytes) {
  arrivals_.push_back({time, bytes});
  while (arrivals_.size() > 2 &&
         (arrivals_.front().time < time - window_ || arrivals_.size() > most_arrivals))
    arrivals_.pop_front();
}

ArrivalRate::Rate ArrivalRate::at(double now) const {
  const auto old = [&](const Arrival& a) { return a.time < now - window_; };
  auto first = std::find_if_not(arrivals_.begin(), arrivals_.end(), old);
  if (arrivals_.size() >= 2) first = std::min(first, arrivals_.end() - 2);
  const auto n = static_cast<double>(arrivals_.end() - first);
  if (n < 2) return {};
  double bytes = 0;
  for (auto a = first; a != arrivals_.end(); ++a) bytes += static_cast<double>(a->bytes);
  // n messages, n - 1 intervals; when the next is overdue, the wait for it counts as well.
  const double mean = std::max((arrivals_.back().time - first->time) / (n - 1), (now - first->time) / n);
  if (mean <= 0) return {};
  const double mean_interval = (arrivals_.back().time - first->time) / (n - 1);
  double squares = 0;
  for (auto a = first; a + 1 != arrivals_.end(); ++a)
    squares += std::pow((a + 1)->time - a->time - mean_interval, 2);
  return {1 / mean, std::sqrt(squares / (n - 1)), bytes / n / mean};
}

}  // namespace lcmslam
