#include "surf/kernel_set.hpp"

#include <algorithm>
#include <atomic>

namespace lcmslam {
namespace {

KernelSet of_processor() {
#ifdef LCMSLAM_HAS_AVX2
  static const bool avx2 = cv::checkHardwareSupport(CV_CPU_AVX2);
  if (avx2) return KernelSet::avx2;
#endif
  return KernelSet::baseline;
}

std::atomic<KernelSet> limit{KernelSet::avx2};

}  // namespace

KernelSet kernel_set() {
  return std::min(of_processor(), limit.load(std::memory_order_relaxed));
}

KernelSet limit_kernel_set(KernelSet best) {
  return limit.exchange(best);
}

}  // namespace lcmslam
