#pragma once
// The floor in a drive's depth images: which way is up for the camera, and how high it sits.

#include <memory>
#include <optional>
#include <vector>

#include <lcmslam/calibration/drive_calibration.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

class FloorWatch {
 public:
  /// `expected`: T_robot_camera to within 25 degrees. Throws std::invalid_argument for a calibration that
  /// does not pass check().
  FloorWatch(const RgbdCalibration& calibration, const Eigen::Isometry3d& expected);
  ~FloorWatch();

  /// CV_16UC1 mm of the calibration's size.
  void add(const cv::Mat& depth);

  /// The medians of all images; nothing where less than ten show a floor.
  std::optional<FloorSight> sight() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace lcmslam
