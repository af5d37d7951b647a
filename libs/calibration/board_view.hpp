#pragma once
// A board as one image shows it.

#include <optional>

#include <lcmslam/calibration/board.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {

struct BoardView {
  std::string name;                     ///< of the image, for reports
  std::vector<int> ids;                 ///< of the corners seen
  std::vector<Eigen::Vector2d> pixels;  ///< where, in the same order
};

/// Finds the board in a grey image (CV_8UC1), corners to a fraction of a pixel; nothing where it is not to be
/// seen, or less than a dozen of its corners. Throws std::invalid_argument for another type of image.
std::optional<BoardView> find_board(const cv::Mat& grey, const Board& board);

/// Pose T_camera_board from the corners, by least squares of the reprojection error. Nothing where they do
/// not tell one.
std::optional<Eigen::Isometry3d> board_pose(const BoardView& view, const Board& board,
                                            const CameraModel& camera);

}  // namespace lcmslam
