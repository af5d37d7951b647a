#pragma once
// Work on rows by several threads. Each row is a pure function, so the split does not matter.

#include <opencv2/core/utility.hpp>
#include <thread>
#include <vector>

namespace lcmslam {

/// Calls work(first, last) for parts of the rows begin..end-1, on OpenCV's threads: cv::parallel_for_ without
/// the heap allocation of a std::function.
template <typename Work>
void parallel_rows(int begin, int end, const Work& work) {
  struct Body : cv::ParallelLoopBody {
    const Work& f;
    explicit Body(const Work& work_) : f(work_) {}
    void operator()(const cv::Range& range) const override { f(range.start, range.end); }
  };
  if (begin < end) cv::parallel_for_(cv::Range(begin, end), Body(work));
}

/// Calls work(row) for rows 0..rows-1 on `threads` threads of its own; row r goes to thread r mod threads.
template <class Work>
void interleaved_rows(int rows, int threads, const Work& work) {
  const auto part = [&](int first) {
    for (int row = first; row < rows; row += threads) work(row);
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(part, i);
  part(0);
  for (std::thread& thread : others) thread.join();
}

}  // namespace lcmslam
