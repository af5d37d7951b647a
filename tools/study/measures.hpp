#pragma once
// What the studies measure with.

#include <cstddef>
#include <opencv2/core/utility.hpp>
#include <string>

#include <lcmslam/evaluation/median.hpp>

namespace lcmslam {

/// A line under a table whose medians and worst leave out the runs that began new maps; empty without any.
inline std::string new_maps_text(std::size_t broken, std::size_t all) {
  if (broken == 0) return "";
  return "\n" + std::to_string(broken) + " of " + std::to_string(all) +
         " runs began a new map: their errors are of the newest alone, and in no median and no worst\n";
}

/// OpenCV computes with one thread while this lives.
class OneThread {
 public:
  OneThread() : before_(cv::getNumThreads()) { cv::setNumThreads(1); }
  ~OneThread() { cv::setNumThreads(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_;
};

}  // namespace lcmslam
