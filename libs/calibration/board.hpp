#pragma once
// The board that cameras are calibrated with: a checkerboard, or one whose white squares carry ArUco markers
// (ChArUco), of which a part is enough.
//
// Board frame: origin in the upper left corner of the squares as they are printed, x right, y down, z into
// the board; m. The square in the origin is black.

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

constexpr int fewest_corners = 12;  ///< that an image must show of a board

struct BoardSettings {
  std::string kind = "charuco";
  int columns = 10, rows = 7;
  double square = 0.025;
  double marker = 0.6;

  void describe(SettingsVisitor& s) {
    s.choice(
        "kind", kind, {"charuco", "checkerboard"},
        "charuco: squares with markers, of which a part is enough; checkerboard: seen whole or not at all");
    s.number("columns", columns, "squares", {3, 40}, "of the board");
    s.number("rows", rows, "squares", {3, 40}, "of the board");
    s.number("square", square, "m", {1e-3, 1}, "side of a square, measured on the print");
    s.number("marker", marker, "", {0.3, 0.9}, "side of a marker, as a share of its square's");
    s.require(
        (columns + rows) % 2 == 1, "rows",
        "must be odd where columns is even, and even where it is odd: a board that looks the same when it "
        "is turned does not tell which way up it is");
    s.require((columns - 1) * (rows - 1) >= fewest_corners, "rows",
              "must be more: a view needs a dozen inner corners, (columns - 1) x (rows - 1), as 4 x 5 "
              "squares have");
    // What detectors of checkerboards know.
    s.require(kind != "checkerboard" || (columns >= 4 && rows >= 4), "rows",
              "and columns must be 4 or more of a checkerboard");
  }
};

class Board {
 public:
  /// Throws std::invalid_argument when a setting is wrong.
  explicit Board(const BoardSettings& settings = {});

  const BoardSettings& settings() const { return settings_; }
  bool has_markers() const { return settings_.kind == "charuco"; }
  double width() const { return settings_.columns * settings_.square; }  ///< m
  double height() const { return settings_.rows * settings_.square; }

  /// Inner corners, where four squares meet, row by row from the upper left.
  int corners() const { return (settings_.columns - 1) * (settings_.rows - 1); }
  /// m, board frame. `id` from 0 to corners() - 1.
  Eigen::Vector3d corner(int id) const;

  /// Everything on it that is black, rectangles in m.
  const std::vector<cv::Rect2d>& black() const { return black_; }
  /// CV_8UC1 with a white margin of half a square around; a square is so many pixels wide.
  cv::Mat picture(int pixels_per_square) const;
  /// To be printed at its own size: millimetres, the size written below it.
  std::string svg() const;

  /// OpenCV's dictionary of its markers (cv::aruco::PREDEFINED_DICTIONARY_NAME).
  static int dictionary();

 private:
  BoardSettings settings_;
  std::vector<cv::Rect2d> black_;
};

}  // namespace lcmslam
