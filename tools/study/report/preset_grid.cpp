#include "tools/study/report/preset_grid.hpp"

#include "tools/study/report/result_parts.hpp"

namespace lcmslam {

const char* const grid_methods[4] = {"FastSLAM, thesis", "FastSLAM, modern", "ICP, thesis", "ICP, modern"};

std::vector<double> grid_errors(const GridErrors& e) {
  return {e.fastslam[0], e.fastslam[1], e.icp[0], e.icp[1]};
}

std::vector<GridErrors> run_grid(const std::vector<GridCase>& cases) {
  std::vector<GridErrors> all(cases.size());
  run_side_by_side(2 * cases.size(), [&](std::size_t i) {
    const GridCase& one = cases[i / 2];
    const std::size_t preset = i % 2;
    MapperChoice choice;
    choice.preset = preset == 0 ? "thesis" : "modern";
    choice.set = one.set;
    choice.seed = one.seed;
    const MappingRun run = map_drive(*one.drive, choice);
    const Trajectory& truth = one.drive->truth;
    GridErrors& errors = all[i / 2];
    if (preset == 0) errors.odometry = path_error(truth, run.odometry);
    errors.fastslam[preset] = path_error(truth, run.fastslam);
    errors.icp[preset] = path_error(truth, run.icp);
    constexpr std::size_t points = 4000;
    errors.icp_map[preset] = quantile_of(
        surface_distances(*one.drive, fit_to_truth(truth, run.icp), places_of(run.cloud), points), 0.5);
    errors.fastslam_map[preset] = quantile_of(
        surface_distances(*one.drive, fit_to_truth(truth, run.fastslam), places_of(run.landmarks), points),
        0.5);
  });
  return all;
}

}  // namespace lcmslam
