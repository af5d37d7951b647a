#pragma once
#include <lcmslam/calibration/board_view.hpp>

namespace lcmslam {

/// Which frames of a running camera are worth a view: those in which the board is held still, where no other
/// view has it. Of images that somebody took one by one, all.
class ViewChoice {
 public:
  explicit ViewChoice(bool sequence) : sequence_(sequence) {}

  bool takes(const BoardView& view, int image_width);

 private:
  static double distance(const BoardView& a, const BoardView& b);  ///< pixels, mean of the corners of both

  bool sequence_;
  BoardView previous_;
  std::vector<BoardView> taken_;
};

}  // namespace lcmslam
