#pragma once
#include <lcmslam/calibration/view_coverage.hpp>

namespace lcmslam {

/// m, from which to which the board's middle is to be held.
struct WantedRanges {
  double nearest = 1e9, farthest = 0;
};

/// While somebody holds a board before a camera that runs: says how many views there are and what the next
/// one should show. True when nothing is missing, and the focal length is as sure as it should be.
bool tell_whether_enough(const std::vector<BoardView>& views, const Board& board, cv::Size image_size,
                         const CameraCalibrationSettings& settings = {}, const WantedRanges& ranges = {});

}  // namespace lcmslam
