#include <lcmslam/parallel/instruction_set.hpp>

#include <algorithm>
#include <atomic>

namespace lcmslam {
namespace {

std::atomic<InstructionSet> limit{InstructionSet::avx2};

InstructionSet best_of_processor() {
  if (has(InstructionSet::avx2)) return InstructionSet::avx2;
  return has(InstructionSet::sse2) ? InstructionSet::sse2 : InstructionSet::portable;
}

}  // namespace

bool has(InstructionSet set) {
#ifdef LCMSLAM_HAS_AVX2
  return set != InstructionSet::avx2 || __builtin_cpu_supports("avx2");
#else
  return set == InstructionSet::portable;
#endif
}

InstructionSet best_instruction_set() {
  static const InstructionSet best = best_of_processor();
  return std::min(best, limit.load(std::memory_order_relaxed));
}

InstructionSet limit_instruction_set(InstructionSet best) {
  return limit.exchange(best);
}

}  // namespace lcmslam
