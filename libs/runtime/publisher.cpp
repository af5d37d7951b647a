#include <lcmslam/runtime/publisher.hpp>

#include <algorithm>

namespace lcmslam {

void Publisher::forward(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) {
  const std::lock_guard<std::mutex> lock(mutex_);
  count(channel, bytes.size(), utime);
  send(channel, bytes, utime);
}

void Publisher::count(const std::string& channel, std::size_t bytes, Utime utime) {
  OutputCount& count = counts_[channel];
  count.sent += 1;
  count.bytes += static_cast<std::int64_t>(bytes);
  count.largest = std::max(count.largest, static_cast<std::int64_t>(bytes));
  count.last_utime = utime;
}

std::map<std::string, OutputCount> Publisher::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

}  // namespace lcmslam
