#pragma once
// Memory for the nodes of PersistentArray. Particles copy and drop thousands of nodes of one size in a step,
// in all threads: here that costs a few instructions, and what was freed last, still in the cache, is used
// next. Each thread keeps a list of free nodes; what is too much for it goes over in batches to those that
// all threads share, since resampling frees in one thread what others allocated.
//
// Memory that is given back serves later nodes of the same size and nothing else.

#include <cstddef>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#ifdef __SANITIZE_ADDRESS__
#define LCMSLAM_NO_NODE_POOL  // so that AddressSanitizer sees each node
#endif

namespace lcmslam {

/// Nodes of `kBytes`, aligned as std::max_align_t is. Any thread may give back what any other took.
template <std::size_t kBytes>
class NodePool {
 public:
  static void* take() {
#ifdef LCMSLAM_NO_NODE_POOL
    return ::operator new(kBytes);
#else
    if (!free_) refill();
    --count_;
    return std::exchange(free_, free_->next);
#endif
  }

  static void give_back(void* memory) {
#ifdef LCMSLAM_NO_NODE_POOL
    ::operator delete(memory);
#else
    free_ = new (memory) Free{free_};
    if (++count_ >= 2 * kBatch) hand_over(kBatch);
#endif
  }

 private:
  struct Free {
    Free* next;
  };
  static_assert(kBytes >= sizeof(Free) && kBytes % alignof(std::max_align_t) == 0);
  static constexpr int kBatch = 64;

  struct Batch {
    Free* first;
    int count;
  };
  struct Shared {
    std::mutex mutex;
    std::vector<Batch> batches;
    std::vector<void*> blocks;  // all memory, so that leak checkers find it
  };
  static Shared& shared() {
    static auto* const forever = new Shared;  // other static objects may own nodes when the program ends
    return *forever;
  }

  struct HandOverAtExit {
    ~HandOverAtExit() {
      if (count_ > 0) hand_over(count_);
    }
  };

  static void refill() {
    static thread_local HandOverAtExit at_exit;
    static_cast<void>(at_exit);
    const std::lock_guard<std::mutex> lock(shared().mutex);
    if (!shared().batches.empty()) {
      free_ = shared().batches.back().first;
      count_ = shared().batches.back().count;
      shared().batches.pop_back();
      return;
    }
    count_ = kBatch;
    shared().blocks.push_back(::operator new(kBatch* kBytes));
    auto* block = static_cast<std::byte*>(shared().blocks.back());
    for (int i = kBatch; i-- > 0;) free_ = new (block + static_cast<std::size_t>(i) * kBytes) Free{free_};
  }

  static void hand_over(int number) {
    Free* const first = free_;
    Free* last = first;
    for (int i = 1; i < number; ++i) last = last->next;
    free_ = std::exchange(last->next, nullptr);
    count_ -= number;
    const std::lock_guard<std::mutex> lock(shared().mutex);
    shared().batches.push_back({first, number});
  }

  static thread_local inline Free* free_ = nullptr;
  static thread_local inline int count_ = 0;
};

}  // namespace lcmslam
