#pragma once
// Memory for the nodes of PersistentArray. Particles copy and drop thousands of nodes of one size in a step,
// in all threads: here that costs a few instructions, and what was freed last, still in the cache, is used
// next. Each thread keeps a list of free nodes; what is too much for it goes over in batches to those that
// all threads share, since resampling frees in one thread what others allocated.
//
// Memory that is given back serves later nodes of the same size and nothing else.

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#ifdef __SANITIZE_ADDRESS__
#define LCMSLAM_NO_NODE_POOL  // so that AddressSanitizer sees each node
#endif

namespace lcmslam {

/// Nodes of `node_bytes`, aligned as std::max_align_t is. Any thread may give back what any other took.
template <std::size_t node_bytes>
class NodePool {
 public:
  static void* take() {
#ifdef LCMSLAM_NO_NODE_POOL
    return ::operator new(node_bytes);
#else
    if (count_ == 0) refill();
    void* const memory = free_[--count_];
    if (count_ >= prefetch_ahead) fetch(free_[count_ - prefetch_ahead]);
    return memory;
#endif
  }

  static void give_back(void* memory) {
#ifdef LCMSLAM_NO_NODE_POOL
    ::operator delete(memory);
#else
    free_[count_++] = memory;
    if (count_ == 2 * batch_size) hand_over(batch_size);
#endif
  }

 private:
  static_assert(node_bytes % alignof(std::max_align_t) == 0);
  static constexpr std::size_t batch_size = 64;
  static constexpr std::size_t prefetch_ahead =
      3;  // so many takes before it is used a node is fetched into the cache

  struct Batch {
    std::array<void*, batch_size> nodes;
    std::size_t count;
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

  static void fetch(void* memory) {
#ifdef __GNUC__
    for (std::size_t i = 0; i < node_bytes; i += 64)
      __builtin_prefetch(static_cast<std::byte*>(memory) + i, 1);
#else
    static_cast<void>(memory);
#endif
  }

  struct HandOverAtExit {
    ~HandOverAtExit() {
      while (count_ > 0) hand_over(std::min(count_, batch_size));
    }
  };

  static void refill() {
    static thread_local HandOverAtExit at_exit;
    static_cast<void>(at_exit);
    const std::lock_guard<std::mutex> lock(shared().mutex);
    if (!shared().batches.empty()) {
      const Batch& batch = shared().batches.back();
      count_ = batch.count;
      std::copy_n(batch.nodes.begin(), count_, free_.begin());
      shared().batches.pop_back();
      return;
    }
    count_ = batch_size;
    shared().blocks.push_back(::operator new(batch_size* node_bytes));
    auto* block = static_cast<std::byte*>(shared().blocks.back());
    for (std::size_t i = 0; i < batch_size; ++i) free_[i] = block + (batch_size - 1 - i) * node_bytes;
  }

  // Those that were freed first: they have left the cache.
  static void hand_over(std::size_t number) {
    Batch batch;
    batch.count = number;
    std::copy_n(free_.begin(), number, batch.nodes.begin());
    std::copy(free_.begin() + static_cast<std::ptrdiff_t>(number),
              free_.begin() + static_cast<std::ptrdiff_t>(count_), free_.begin());
    count_ -= number;
    const std::lock_guard<std::mutex> lock(shared().mutex);
    shared().batches.push_back(batch);
  }

  static thread_local inline std::array<void*, 2 * batch_size> free_{};
  static thread_local inline std::size_t count_ = 0;
};

}  // namespace lcmslam
