#pragma once
// A depth image as carving asks for it: through an ideal pinhole, in metres, with the nearest depth around
// each pixel (what a cell's whole width sees through) and the extremes of tiles (what a block sees through).

#include <array>
#include <opencv2/core.hpp>

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

class CarvingView {
 public:
  static constexpr int tile = 16;                         ///< pixels
  static constexpr std::array<int, 4> radii{0, 1, 3, 7};  ///< pixels, around which nearest() looks

  /// `depth` of the camera's size along the optical axis: CV_32FC1 m, CV_16UC1 mm or CV_16SC1 mm. Zero and
  /// what is not finite is no measurement; below zero: space is free up to there, and what was measured
  /// there is gone. Throws std::invalid_argument when size or type are wrong.
  void set(const cv::Mat& depth, const CameraModel& camera);

  const CameraModel& camera() const { return camera_; }  ///< without distortion
  /// CV_32FC1 m, signed as above.
  const cv::Mat& depth() const { return depth_; }
  /// CV_32FC1 m: the smallest depth that was measured in the square of radii[level]; 0 where about two thirds
  /// of it have none.
  const cv::Mat& nearest(int level) const { return nearest_[static_cast<std::size_t>(level)]; }
  /// The smallest level whose radius is at least `radius` pixels, or the last.
  static int level_for(float radius);

  struct Extremes {
    float least;  ///< m; 0 where a pixel has no depth
    float most;   ///< m; 0 where none has
  };
  /// Of tiles that cover the pixels first..last (inclusive, inside the image).
  Extremes extremes(const Eigen::Vector2i& first, const Eigen::Vector2i& last) const;
  float farthest() const { return farthest_; }  ///< m, of all

 private:
  void undistort();
  void find_nearest();
  void find_extremes();

  CameraModel camera_;
  std::vector<double> distortion_;
  std::vector<std::int32_t> source_;  // measured pixel of each ideal one, -1: none; empty without distortion
  cv::Mat raw_, depth_, filled_, hole_, holes_;
  std::array<cv::Mat, radii.size()> nearest_;
  cv::Mat_<cv::Vec2f> tiles_;
  float farthest_ = 0;
};

}  // namespace lcmslam
