#pragma once
// Moments of all cells of a depth image in one pass.

#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/planes/plane_moments.hpp>

namespace lcmslam {

/// Rays of a depth camera, and sums that are used again.
class CellMoments {
 public:
  /// `cell`: pixels on a side; columns and rows that do not fill a cell are left out. Throws
  /// std::invalid_argument for a calibration that is wrong, or of cells that are together less than 8
  /// pixels wide.
  CellMoments(const RgbdCalibration& calibration, int cell);

  const CameraModel& camera() const { return calibration_.depth; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int side() const { return cell_; }  ///< pixels

  /// Of each cell in rows from the upper left, in the depth camera's frame. `depth` CV_16UC1 mm. Points weigh
  /// 1 / sigma^2 at their cell's mean depth.
  std::vector<PlaneMoments> operator()(const cv::Mat& depth);

  /// Point of a pixel, m.
  Eigen::Vector3f point(int v, int u, float z) const { return {z * ray_x_(v, u), z * ray_y_(v, u), z}; }
  double sigma(double z) const { return calibration_.depth_noise.sigma(z); }
  /// The same by measured depth, mm; infinity where it cannot be one.
  const float* sigmas() const { return sigmas_.data(); }
  const float* ray_x(int v) const { return ray_x_[v]; }  ///< x/z along a row
  const float* ray_y(int v) const { return ray_y_[v]; }  ///< y/z

 private:
  RgbdCalibration calibration_;
  int cell_, columns_, rows_;
  cv::Mat_<float> ray_x_, ray_y_;
  std::vector<float> sigmas_;  // m, by mm
  std::vector<float> sums_;    // rows of columns: count, x, y, z, xx, xy, xz, yy, yz, zz
  std::vector<float> places_;  // rows of columns: x, y, z of a point of the column's cell, m
};

}  // namespace lcmslam
