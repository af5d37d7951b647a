#include <lcmslam/runtime/publisher.hpp>

namespace lcmslam {

std::map<std::string, OutputCount> Publisher::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counts_;
}

}  // namespace lcmslam
