#pragma once
// Changed drives through both mappers with both presets: what several experiments ask.

#include <string>
#include <vector>

#include "tools/study/report/mapping_run.hpp"

namespace lcmslam {

/// One drive as it was changed, and what is told to the mappers besides.
struct GridCase {
  std::string name;
  const Drive* drive = nullptr;
  std::vector<std::string> set;
  int seed = 1;
};

/// ATE RMSE in m; NaN without a path.
struct GridErrors {
  double odometry = 0;
  double fastslam[2] = {0, 0}, icp[2] = {0, 0};  ///< thesis, modern
  double icp_map[2] = {0, 0};                    ///< median distance of its points from true surfaces, m
  double fastslam_map[2] = {0, 0};
};

/// Names of the four, and their errors in that order.
extern const char* const grid_methods[4];
std::vector<double> grid_errors(const GridErrors& errors);

/// In the order of the cases.
std::vector<GridErrors> run_grid(const std::vector<GridCase>& cases);

}  // namespace lcmslam
