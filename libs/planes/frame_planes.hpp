#pragma once
// The planes of one depth image: cells that are plane, grown together where they agree, and what of their
// borders belongs to them pixel by pixel (after Proença and Gao, "Fast cylinder and plane extraction from
// depth cameras", IROS 2018; without cylinders).

#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/planes/cell_moments.hpp>
#include <lcmslam/planes/plane_settings.hpp>

namespace lcmslam {

struct FramePlane {
  PlaneMoments moments;  ///< of its plane cells, in the depth camera's frame
  PlaneFit fit;
};

struct FramePlanes {
  std::vector<FramePlane> planes;  ///< largest first
  cv::Mat
      labels;  ///< CV_8UC1 of the depth image's size: number of the plane from 1 on, 0 where there is none
};

class FramePlaneFinder {
 public:
  static constexpr std::size_t most_planes = 255;

  /// Throws std::invalid_argument for a calibration or a setting that is wrong.
  FramePlaneFinder(const RgbdCalibration& calibration, const FramePlaneSettings& settings = {});

  /// `depth` CV_16UC1 mm of the calibration's size, as from DepthFilter; throws std::invalid_argument for
  /// another.
  FramePlanes operator()(const cv::Mat& depth);

  const CellMoments& cells() const { return moments_; }

 private:
  struct Cell {
    PlaneFit fit;
    double sigma = 0;  // m, of its depth
    bool plane = false;
    int region = 0;  // 0: none yet
  };
  struct Direction {
    std::vector<int> cells;  // plane cells that look there
    int free = 0;            // of them, without a region
  };

  void fit_cells(const cv::Mat& depth);
  std::vector<Direction> directions_of_cells() const;
  int next_seed(std::vector<Direction>& directions) const;
  std::vector<int> grow(int seed, int region);
  bool lies_in(const PlaneEquation& plane, int cell) const;
  PlaneMoments sum_of(const std::vector<int>& cells) const;
  bool are_one(const PlaneFit& a, const PlaneFit& b) const;
  std::vector<std::vector<int>> join_regions(std::vector<std::vector<int>> regions) const;

  FramePlaneSettings settings_;
  CameraModel camera_;
  int cell_;  // pixels on a side
  CellMoments moments_;
  std::vector<PlaneMoments> cell_moments_;
  std::vector<Cell> cells_;
};

}  // namespace lcmslam
