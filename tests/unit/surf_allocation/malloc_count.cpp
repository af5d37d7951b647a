#include "tests/unit/surf_allocation/malloc_count.hpp"

#include <atomic>
#include <cerrno>
#include <cstdlib>

namespace {

std::atomic<long> calls{0}, bytes{0};

}  // namespace

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
namespace {

void count(std::size_t size) {
  ++calls;
  bytes += static_cast<long>(size);
}

}  // namespace

extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): they are glibc's.
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t size) {
  count(size);
  return __libc_malloc(size);
}
void* calloc(std::size_t items, std::size_t size) {
  count(items * size);
  return __libc_calloc(items, size);
}
void* realloc(void* memory, std::size_t size) {
  count(size);
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(size);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  count(size);
  *memory = __libc_memalign(alignment, size);
  return *memory || size == 0 ? 0 : ENOMEM;
}
}
#endif

namespace lcmslam::testing {

long malloc_calls() {
  return calls;
}

long malloc_bytes() {
  return bytes;
}

}  // namespace lcmslam::testing
