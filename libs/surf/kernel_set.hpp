#pragma once
// Which instructions the row kernels may use. A kernel is one plain loop, compiled twice: for the
// baseline (SSE2 on x86-64) and for AVX2, chosen at run time. Without fused multiply-adds and with
// sums in a fixed order both give the same bits.

#include <opencv2/core/utility.hpp>

#if defined(__x86_64__) && defined(__GNUC__)
#define LCMSLAM_HAS_AVX2
#define LCMSLAM_AVX2 __attribute__((target("avx2")))
#endif

namespace lcmslam {

enum class KernelSet { baseline, avx2 };

/// The best that both the processor and the limit allow.
KernelSet kernel_set();

/// For tests: use nothing better than this from now on, in all threads. Returns the former limit.
KernelSet limit_kernel_set(KernelSet best);

/// cv::parallel_for_ without the heap allocation of a std::function.
template <typename Function>
void parallel_rows(int begin, int end, const Function& function) {
  struct Body : cv::ParallelLoopBody {
    const Function& f;
    explicit Body(const Function& function_) : f(function_) {}
    void operator()(const cv::Range& range) const override { f(range.start, range.end); }
  };
  if (begin < end) cv::parallel_for_(cv::Range(begin, end), Body(function));
}

}  // namespace lcmslam

// LCMSLAM_KERNEL(name, (parameters), (arguments)) { body }: defines name(parameters), which runs the
// body compiled for kernel_set(). The body must be a loop over plain arrays.
#ifdef LCMSLAM_HAS_AVX2
#define LCMSLAM_KERNEL(name, parameters, arguments)                                      \
  __attribute__((always_inline)) inline void name##_body parameters;                     \
  LCMSLAM_AVX2 void name##_avx2 parameters {                                             \
    name##_body arguments;                                                               \
  }                                                                                      \
  void name##_baseline parameters {                                                      \
    name##_body arguments;                                                               \
  }                                                                                      \
  void name parameters {                                                                 \
    kernel_set() == KernelSet::avx2 ? name##_avx2 arguments : name##_baseline arguments; \
  }                                                                                      \
  __attribute__((always_inline)) inline void name##_body parameters
#else
#define LCMSLAM_KERNEL(name, parameters, arguments) void name parameters
#endif
