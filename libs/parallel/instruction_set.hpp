#pragma once
// Loops that are compiled for several instruction sets, the best of which is chosen at run time. Without
// fused multiply-adds (-ffp-contract=off; AVX2 alone has none) and with sums in a fixed order all give the
// same bits.

#if defined(__x86_64__) && defined(__GNUC__)
#define LCMSLAM_HAS_AVX2
#define LCMSLAM_AVX2 __attribute__((target("avx2")))
#endif

namespace lcmslam {

enum class InstructionSet { portable, sse2, avx2 };

/// Whether this build and this processor have it.
bool has(InstructionSet set);

/// The best one that they have and the limit allows.
InstructionSet best_instruction_set();

/// For tests: use nothing better than this from now on, in all threads. Returns the former limit.
InstructionSet limit_instruction_set(InstructionSet best);

}  // namespace lcmslam

// LCMSLAM_VECTORISED(name, (parameters), (arguments)) { body }: defines name(parameters), which runs the body
// as compiled for best_instruction_set(). The body must be a loop over plain arrays.
#ifdef LCMSLAM_HAS_AVX2
#define LCMSLAM_VECTORISED(name, parameters, arguments)                                           \
  __attribute__((always_inline)) inline void name##_body parameters;                              \
  LCMSLAM_AVX2 void name##_avx2 parameters {                                                      \
    name##_body arguments;                                                                        \
  }                                                                                               \
  void name##_portable parameters {                                                               \
    name##_body arguments;                                                                        \
  }                                                                                               \
  void name parameters {                                                                          \
    lcmslam::best_instruction_set() == lcmslam::InstructionSet::avx2 ? name##_avx2 arguments      \
                                                                     : name##_portable arguments; \
  }                                                                                               \
  __attribute__((always_inline)) inline void name##_body parameters
#else
#define LCMSLAM_VECTORISED(name, parameters, arguments) void name parameters
#endif
