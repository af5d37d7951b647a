#pragma once
// What this program asks of malloc, operator new and OpenCV's matrices too: so it is a program of its own.

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define LCMSLAM_COUNTS_MALLOC
#endif

namespace lcmslam::testing {

/// So far, on all threads; without LCMSLAM_COUNTS_MALLOC always 0.
long malloc_calls();
long malloc_bytes();

}  // namespace lcmslam::testing
