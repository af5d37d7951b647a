#pragma once
// What this program asks of malloc, operator new and OpenCV's matrices too: so it is a program of its own.

namespace lcmslam::testing {

/// So far, on all threads; with a sanitizer, whose malloc cannot be counted, 0.
long malloc_calls();
long malloc_bytes();

}  // namespace lcmslam::testing
