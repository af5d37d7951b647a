#pragma once
// How a colour and a depth camera sit on each other, from views of a board that both took at one moment.

#include <optional>
#include <vector>

#include <lcmslam/calibration/board_view.hpp>
#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

struct PairView {
  BoardView colour, depth;  ///< of the colour image and of the depth camera's amplitude image
};

struct PairSettings {
  /// The depth camera's fx, fy, cx, cy are refined with the rest: a ToF camera's few pixels tell its focal
  /// length and the board's distance hardly apart, but here the colour camera knows the distance.
  bool refine_depth_camera = true;
};

struct PairCalibration {
  Eigen::Isometry3d T_colour_depth = Eigen::Isometry3d::Identity();
  Matrix6d covariance =
      Matrix6d::Zero();  ///< T exp(xi): translation (m), then rotation (rad), depth camera's frame
  CameraModel depth;     ///< as refined
  Eigen::Matrix4d depth_covariance = Eigen::Matrix4d::Zero();  ///< of its fx, fy, cx, cy; pixels
  double colour_rms = 0, depth_rms = 0;                        ///< pixels, of both axes together
  /// Of each view, by the colour camera and the pair; nothing where the view was of no use.
  std::vector<std::optional<Eigen::Isometry3d>> T_depth_board;
  int views = 0;  ///< that were of use
};

/// Throws std::invalid_argument for less than three views, std::runtime_error where they do not tell.
PairCalibration calibrate_pair(const std::vector<PairView>& views, const Board& board,
                               const CameraModel& colour, const CameraModel& depth,
                               const PairSettings& settings = {});

}  // namespace lcmslam
