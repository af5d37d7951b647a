#pragma once
// Intrinsics of a camera from views of a board (Zhang 2000, "A flexible new technique for camera
// calibration"), with their covariance.

#include <lcmslam/calibration/board_view.hpp>

namespace lcmslam {

struct CameraCalibrationSettings {
  /// Distortion coefficients: 0, 4, 5 or 8; -1: as many of 0, 4 and 5 as the views bear (least BIC).
  int coefficients = -1;
  double outlier = 5;  ///< corners farther off than so many standard deviations are left out
};

/// One view as the finished calibration sees it.
struct CalibratedView {
  BoardView view;
  Eigen::Isometry3d T_camera_board = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector2d> residuals;  ///< pixels, measured - projected, a corner each
  double rms = 0;                          ///< pixels, of both axes together
};

struct CameraCalibration {
  CameraModel camera;
  /// Of fx, fy, cx, cy and the coefficients, in this order; pixels and no unit.
  Eigen::MatrixXd covariance;
  double rms = 0;  ///< pixels, reprojection error of both axes together
  std::vector<CalibratedView> views;
  int outliers = 0;  ///< corners left out

  double sigma(int parameter) const { return std::sqrt(covariance(parameter, parameter)); }
};

/// Throws std::invalid_argument for less than three views, std::runtime_error where they do not determine a
/// camera.
CameraCalibration calibrate_camera(const std::vector<BoardView>& views, const Board& board,
                                   cv::Size image_size, const CameraCalibrationSettings& settings = {});

}  // namespace lcmslam
