#pragma once
// Is a set of views good enough to calibrate a camera with, and which are missing?

#include <array>

#include <lcmslam/calibration/camera_calibration.hpp>

namespace lcmslam {

struct ViewCoverage {
  static constexpr int cells = 4;                          ///< across and down
  std::array<std::array<int, cells>, cells> corners = {};  ///< seen in each, [row][column]
  double smallest_tilt = 0, largest_tilt = 0;              ///< rad, between the board and the image plane
  int tilted_views = 0;                                    ///< by at least 15 degrees
  double tilt_across = 0, tilt_down = 0;                   ///< rad, largest about the image's axes
  double nearest = 0, farthest = 0;                        ///< m, of the board's middle
  double largest = 0;                                      ///< share of the image's width that a view filled

  /// Share of the cells that have corners.
  double filled() const;
};

ViewCoverage coverage_of(const CameraCalibration& calibration, const Board& board);

struct CoverageLimits {
  int fewest_views = 8;
  double focal_sigma = 0.003;   ///< of the focal length's relative error: less sure is refused
  double wanted_sigma = 0.001;  ///< of the same: a view more is wanted until three sigmas are 0.3 %
  double rms = 1.5;             ///< pixels
};

/// Why the set is refused, and what to add; none: it is good.
std::vector<std::string> missing_views(const CameraCalibration& calibration, const ViewCoverage& coverage,
                                       const CoverageLimits& limits = {});

/// What would make a good set better: which views, and about how many, until the focal length is as sure as
/// it should be; none: it is.
std::vector<std::string> wanted_views(const CameraCalibration& calibration, const ViewCoverage& coverage,
                                      const CoverageLimits& limits = {});

}  // namespace lcmslam
