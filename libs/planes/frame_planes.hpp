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
    PlaneMoments moments;
    PlaneFit fit;
    bool plane = false;
    int region = 0;  // 0: none yet
  };

  void fit_cells(const cv::Mat& depth);
  int best_seed(const std::vector<int>& histogram) const;
  int direction(const Eigen::Vector3d& normal) const;
  std::vector<int> grow(int seed, int region);
  bool agree(const PlaneFit& a, const PlaneFit& b) const;
  std::vector<std::vector<int>> join_regions(std::vector<std::vector<int>> regions);
  void label_pixels(const cv::Mat& depth, const std::vector<std::vector<int>>& regions,
                    FramePlanes& found) const;

  FramePlaneSettings settings_;
  CameraModel camera_;
  int cell_;  // pixels on a side
  CellMoments moments_;
  std::vector<Cell> cells_;
};

}  // namespace lcmslam
