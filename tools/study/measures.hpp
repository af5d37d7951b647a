#pragma once
// What the studies measure with.

#include <opencv2/core/utility.hpp>

#include <lcmslam/evaluation/median.hpp>

namespace lcmslam {

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
