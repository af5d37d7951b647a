#include <lcmslam/web/link_rate.hpp>

#include <algorithm>

namespace lcmslam {

void LinkRate::sent(std::uint64_t bytes, double now) {
  if (under_way() == 0) delivered_at_ = heard_ = now;  // the link was idle
  line_ = rate_ * line(now) + static_cast<double>(bytes);
  line_at_ = now;
  sent_ += bytes;
  flights_.push_back({sent_, now, delivered_, delivered_at_});
}

void LinkRate::acknowledged(std::uint64_t total, double now) {
  total = std::min(total, sent_);
  if (total <= delivered_) return;
  delivered_ = total;
  delivered_at_ = heard_ = now;
  while (!flights_.empty() && flights_.front().end <= delivered_) {
    const Flight flight = flights_.front();
    flights_.pop_front();
    const double way = std::max(now - flight.sent, 1e-4);
    probed_way_ = std::min(probed_way_, way);
    if (way_seen_ < 0 || way < round_trip_) round_trip_ = way;
    if (way < round_trip_ + negligible) way_seen_ = now;
    const double since = std::max(now - flight.delivered_at, way);
    rates_.push_back({now, static_cast<double>(delivered_ - flight.delivered) / since});
  }
  while (rates_.size() > 1 && rates_.front().at < now - remembered) rates_.pop_front();
  const auto smaller = [](const Sample& a, const Sample& b) { return a.value < b.value; };
  if (!rates_.empty()) rate_ = std::max_element(rates_.begin(), rates_.end(), smaller)->value;
}

double LinkRate::line(double now) const {
  return std::max(0.0, line_ / rate_ - (now - line_at_));
}

bool LinkRate::is_probing(double now) {
  if (probe_ >= 0 && now - probe_ < probe) return true;
  if (probe_ >= 0 &&
      probe_ > way_seen_) {  // it is over and the old way was not seen again: there is a new one
    if (probed_way_ < 1e9) round_trip_ = probed_way_;
    way_seen_ = now;
  }
  if (way_seen_ < 0 || now - way_seen_ < believed) return false;
  probe_ = now;
  probed_way_ = 1e9;
  return true;
}

double LinkRate::window(double delay) const {
  return std::max(smallest, rate_ * (round_trip_ + delay));
}

}  // namespace lcmslam
