#pragma once
// Work on image rows by a few threads. Each row is a pure function, so the split does not matter.

#include <thread>
#include <vector>

namespace lcmslam {

/// Calls work(row) for rows 0..rows-1; row r goes to thread r mod threads.
template <class Work>
void for_rows(int rows, int threads, const Work& work) {
  const auto part = [&](int first) {
    for (int row = first; row < rows; row += threads) work(row);
  };
  std::vector<std::thread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(part, i);
  part(0);
  for (std::thread& thread : others) thread.join();
}

}  // namespace lcmslam
