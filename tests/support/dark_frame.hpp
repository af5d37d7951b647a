#pragma once
// A time-of-flight head before a wall full of blobs, which may be dark.

#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/rgbd_frame.hpp>

namespace lcmslam::testing {

/// A turn of its phase is 7.5 m.
inline RgbdCalibration phase_head() {
  RgbdCalibration c;
  c.colour.width = c.depth.width = 320;
  c.colour.height = c.depth.height = 240;
  c.colour.fx = c.colour.fy = c.depth.fx = c.depth.fy = 280;
  c.colour.cx = c.depth.cx = 159.5;
  c.colour.cy = c.depth.cy = 119.5;
  c.depth_noise = {0.002, 0, 0, 0.001};
  c.depth_max = 7.5;
  return c;
}

/// 2 m before it. An amplitude of 11 or less may be of something 9.5 m away.
inline RgbdFrame wall_of_blobs(const RgbdCalibration& c, Utime utime, int amplitude) {
  constexpr int blob = 8;  // pixels
  cv::Mat noise(c.colour.height / blob, c.colour.width / blob, CV_8UC3);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  RgbdFrame frame;
  frame.utime = frame.depth_utime = utime;
  cv::resize(noise, frame.colour, {c.colour.width, c.colour.height}, 0, 0, cv::INTER_CUBIC);
  frame.depth = cv::Mat(c.depth.height, c.depth.width, CV_16UC1, cv::Scalar(2000));
  frame.amplitude = cv::Mat(c.depth.height, c.depth.width, CV_8UC1, cv::Scalar(amplitude));
  return frame;
}

}  // namespace lcmslam::testing
