// Beyond the thesis: how much noise of the odometry, how little texture, how few images and how much change
// of light do both mappers bear, with both presets? Pairs of the four, as heat maps.

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "tools/study/report/image_changes.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/preset_grid.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

/// One plane of the four-dimensional map. `drives` by column, `noise` (m a draw) by row.
struct RobustnessPlane {
  std::string title;
  ChartAxis column;
  std::vector<double> columns, noise;
};

void add_heat_maps(const RobustnessPlane& plane, const std::vector<std::vector<std::vector<double>>>& errors,
                   ExperimentResult& result) {
  for (std::size_t m = 0; m < 4; ++m) {
    HeatMap map{fmt::format("{}: {}", grid_methods[m], plane.title),
                plane.column,
                {"odometry noise a draw", "cm"},
                {"pose error", "cm", true},
                plane.columns,
                {},
                {}};
    for (std::size_t row = 0; row < plane.noise.size(); ++row) {
      map.rows.push_back(100 * plane.noise[row]);
      map.values.emplace_back();
      for (std::size_t column = 0; column < plane.columns.size(); ++column)
        map.values.back().push_back(100 * spread_of(errors[row * plane.columns.size() + column][m]).median);
    }
    result.heat_maps.push_back(map);
  }
}

ExperimentResult study_robustness(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "kitchen", 1);
  const double rate = usual.frame_rate;
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  if (seeds.size() > 2) seeds.resize(2);
  result.seeds = seeds;
  const std::vector<double> noise =
      context.quick ? std::vector<double>{0, 0.05} : std::vector<double>{0, 0.02, 0.05, 0.1};
  const std::vector<RobustnessPlane> planes = {
      {"noise and texture",
       {"texture left", "%"},
       context.quick ? std::vector<double>{100, 10} : std::vector<double>{100, 30, 10, 3},
       noise},
      {"noise and frame rate",
       {"images used", "Hz"},
       context.quick ? std::vector<double>{3, 1} : std::vector<double>{5, 2.5, 1.25},
       noise},
      {"noise and change of light",
       {"swing of the light", "stops"},
       context.quick ? std::vector<double>{0, 2} : std::vector<double>{0, 1, 2, 3},
       noise}};
  result.settings = {{"scene", "kitchen"},
                     {"seconds", usual.seconds},
                     {"frame_rate_hz", rate},
                     {"noise", "random_walk, 10 Hz"}};
  ResultTable table{
      "Robustness",
      {"changed", "value", "odometry noise cm", "mapper", "seed", "pose error cm", "odometry's error cm"},
      {}};
  int failed[4] = {0, 0, 0, 0}, cells = 0;
  std::size_t done = 0;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const RobustnessPlane& plane = planes[p];
    std::vector<std::vector<std::vector<double>>> errors(plane.noise.size() * plane.columns.size(),
                                                         std::vector<std::vector<double>>(4));
    for (const int seed : seeds) {
      const auto drive = drives.drive(usual_drive(context.quick, "kitchen", seed));
      std::vector<Drive> changed;
      for (const double value : plane.columns) {
        if (p == 0) changed.push_back(value < 100 ? with_images(*drive, smoothed(0.01 * value)) : *drive);
        if (p == 1) changed.push_back(every_nth(*drive, static_cast<int>(std::lround(rate / value))));
        if (p == 2) changed.push_back(value > 0 ? with_images(*drive, flickering(value)) : *drive);
      }
      std::vector<GridCase> cases;
      for (const double sigma : plane.noise)
        for (const Drive& one : changed) {
          cases.push_back({"", &one, {}, seed});
          if (sigma > 0)
            cases.back().set = {"odometry.noise.mode=random_walk",
                                fmt::format("odometry.noise.sigma={}", sigma)};
        }
      const std::vector<GridErrors> found = run_grid(cases);
      for (std::size_t i = 0; i < found.size(); ++i) {
        ++cells;
        const std::vector<double> e = grid_errors(found[i]);
        for (std::size_t m = 0; m < 4; ++m) {
          errors[i][m].push_back(e[m]);
          failed[m] += e[m] < found[i].odometry ? 0 : 1;
          table.rows.push_back({plane.column.label, plane.columns[i % plane.columns.size()],
                                number(100 * plane.noise[i / plane.columns.size()]), grid_methods[m], seed,
                                number(100 * e[m]), number(100 * found[i].odometry)});
        }
      }
    }
    add_heat_maps(plane, errors, result);
    context.progress(static_cast<double>(++done) / static_cast<double>(planes.size()));
  }
  result.tables = {table};
  const auto best = std::min_element(std::begin(failed), std::end(failed)) - std::begin(failed);
  result.finding = fmt::format(
      "No better than the odometry they were given are thesis FastSLAM in {} of {} cells, modern FastSLAM in "
      "{}, thesis "
      "ICP in {} and modern ICP in {}; {} bears most.",
      failed[0], cells, failed[1], failed[2], failed[3], grid_methods[best]);
  return result;
}

}  // namespace

Experiment robustness_experiment(SharedDrives drives) {
  return {"robustness", "Odometry noise, texture, frame rate and light", "",
          [drives](const StudyContext& context) { return study_robustness(context, *drives); }};
}

}  // namespace lcmslam
