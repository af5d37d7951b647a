#include "tools/calibrate/live_views.hpp"

#include <fmt/format.h>
#include <iostream>

#include "tools/calibrate/shots.hpp"

namespace lcmslam {

bool tell_whether_enough(const std::vector<BoardView>& views, const Board& board, cv::Size image_size,
                         const CameraCalibrationSettings& settings, const WantedRanges& ranges) {
  constexpr std::size_t fewest = 4;  // that tell anything of themselves
  if (views.size() < fewest) {
    tell_views(views.size());
    return false;
  }
  std::string missing = "enough";
  try {
    const CameraCalibration now = calibrate_camera(views, board, image_size, settings);
    const ViewCoverage coverage = coverage_of(now, board);
    auto all = missing_views(now, coverage);
    if (all.empty()) all = wanted_views(now, coverage);
    if (coverage.nearest > ranges.nearest || coverage.farthest < ranges.farthest)
      all.push_back(fmt::format("the board was held {:.1f} to {:.1f} m away: hold it from {:.1f} to {:.1f} m",
                                coverage.nearest, coverage.farthest, ranges.nearest, ranges.farthest));
    if (!all.empty()) missing = all.front();
  } catch (const std::runtime_error& error) {
    missing = error.what();
  }
  std::cout << fmt::format("{} views; {}\n", views.size(), missing) << std::flush;
  return missing == "enough";
}

}  // namespace lcmslam
