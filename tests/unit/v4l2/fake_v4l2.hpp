#pragma once
// A V4L2 camera that is not there: this program's own open(), ioctl(), poll() and select() answer for one
// name, and its clock_gettime() for a wall clock that somebody sets. It takes sizes, formats, rates and
// exposures, and captures images at its pace (numbered_colour, numbered_depth of tests/support), which it
// hands out a moment later.

#include <atomic>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam::testing {

struct FakeV4l2 {
  static constexpr const char* name = "/dev/video-of-the-test";
  static constexpr std::int64_t delay = 12'000;  // us from an image's capture until it is handed out

  // What the test does, also while it is open.
  std::atomic<bool> plugged{true};
  std::atomic<bool> silent{false};
  cv::Size only_size;                   ///< a camera that takes no other; empty: it takes any
  bool has_jpeg = false;                ///< takes the format MJPG
  std::atomic<std::size_t> cut_off{0};  ///< bytes that its JPEG images lack at their end
  std::int64_t waited = 0;              ///< us that its images have lain in the buffers besides

  // What the driver was told.
  cv::Size size{640, 480};
  std::uint32_t format = 0;
  int rate = 30;
  int exposure_mode = 3, exposure = 157;
  int opened = 0, closed = 0;

  // What it captured last: number and time (us, monotonic).
  int number = 0;
  std::vector<unsigned char> jpeg;
  std::int64_t captured = 0;
};

/// us that the wall clock has been set forward.
extern std::atomic<std::int64_t> wall_clock_set;

/// The only one; a new one after reset.
FakeV4l2& fake_v4l2();
void reset_fake_v4l2();

}  // namespace lcmslam::testing
