#pragma once
// Does what a camera head sends fit its calibration? What is well formed can be wrong all the same: a depth
// scale of 5000 for 1000, degrees for radians in a mount, width for height, depth that belongs to the other
// camera's pixels. Each leaves traces in the images themselves:
//
//   depth scale        depths lie outside of what the sensor measures; the floor lies below the floor
//   mount              walls are not upright, surfaces lie below the floor
//   width and height   the principal point is the middle of an image that lies on its side
//   wrong camera       edges of depth lie beside the edges of colour
//
// A finding is a doubt, said in words with what would be right; nothing is refused for it.

#include <array>
#include <string>
#include <vector>

#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/rgbd/edge_offset.hpp>

namespace lcmslam {

/// Depths by their number, whatever the calibration says of the sensor's range.
class DepthHistogram {
 public:
  void add(const cv::Mat& depth_mm);  ///< CV_16UC1, 0: none

  double filled() const;                                ///< share of the pixels that have a depth
  double quantile(double share) const;                  ///< m; 0 without depths
  double share_between(double near, double far) const;  ///< of the depths, m
  std::string in_words() const;

 private:
  static constexpr int bin = 10;  // mm
  std::array<std::int64_t, 65536 / bin + 1> counts_{};
  std::int64_t depths_ = 0, pixels_ = 0;
};

class Plausibility {
 public:
  /// Throws std::invalid_argument when the calibration does not pass check().
  explicit Plausibility(const RgbdCalibration& calibration);

  /// A frame of the calibration's size. A dozen from different places say more than many of one.
  void add(const RgbdFrame& frame);
  int frames() const { return frames_; }

  const DepthHistogram& depths() const { return depths_; }
  const EdgeOffset& edges() const { return edges_; }
  /// What looks wrong, and what would be right; none: nothing does, as far as the frames show.
  std::vector<std::string> findings() const;

 private:
  void add_surfaces(const RegisteredDepth& depth);
  void check_proportions(std::vector<std::string>& found) const;
  void check_depths(std::vector<std::string>& found) const;
  void check_mount(std::vector<std::string>& found) const;
  void check_edges(std::vector<std::string>& found) const;

  DepthRegistration registration_;
  DepthHistogram depths_;
  EdgeOffset edges_;
  int frames_ = 0;
  /// Of points with a normal, in the robot's frame: how many; upright or level within 15 degrees; below the
  /// floor; of the level ones the heights.
  std::int64_t surfaces_ = 0, aligned_ = 0, below_ = 0;
  std::vector<float> level_heights_;
};

/// Of a calibration's width, height and principal point alone; empty: nothing looks wrong.
std::string swapped_sides(const CameraModel& camera, const std::string& name);

}  // namespace lcmslam
