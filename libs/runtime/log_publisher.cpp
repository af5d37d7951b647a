#include <lcmslam/runtime/log_publisher.hpp>

namespace lcmslam {

std::int64_t LogPublisher::bytes() const {
  std::int64_t sum = 0;
  for (const auto& [channel, count] : counts()) sum += count.bytes;
  return sum;
}

}  // namespace lcmslam
