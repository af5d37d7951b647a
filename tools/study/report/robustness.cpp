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

/// One change of the images, by how much, beside noise of the odometry. The first value changes nothing.
struct RobustnessPlane {
  std::string title;
  ChartAxis column;
  std::vector<double> columns;
  std::function<Drive(const Drive&, double value)> change;
};

std::vector<RobustnessPlane> robustness_planes(bool quick, double rate) {
  const auto some = [&](std::vector<double> values) {
    return quick ? std::vector<double>{values.front(), values.back()} : values;
  };
  return {{"noise and texture",
           {"texture left", "%"},
           some({100, 30, 10}),
           [](const Drive& drive, double left) { return with_images(drive, smoothed(0.01 * left)); }},
          {"noise and frame rate",
           {"images used", "Hz"},
           some({rate, rate / 2, rate / 4}),
           [rate](const Drive& drive, double used) {
             return every_nth(drive, static_cast<int>(std::lround(rate / used)));
           }},
          {"noise and change of light",
           {"swing of the light", "stops"},
           some({0, 1, 2}),
           [](const Drive& drive, double stops) { return with_images(drive, flickering(stops)); }}};
}

/// errors[variant][noise][method] of one seed or several; variant 0 is the drive as it is, then every plane's
/// further columns.
using RobustnessErrors = std::vector<std::vector<std::vector<std::vector<double>>>>;

void add_heat_maps(const RobustnessPlane& plane, std::size_t first_variant, const std::vector<double>& noise,
                   const RobustnessErrors& errors, ExperimentResult& result) {
  for (std::size_t m = 0; m < 4; ++m) {
    HeatMap map{fmt::format("{}: {}", grid_methods[m], plane.title),
                plane.column,
                {"odometry noise a draw", "cm"},
                {"pose error", "cm", true},
                plane.columns,
                {},
                {}};
    for (std::size_t row = 0; row < noise.size(); ++row) {
      map.rows.push_back(100 * noise[row]);
      map.values.emplace_back();
      for (std::size_t column = 0; column < plane.columns.size(); ++column) {
        const std::size_t variant = column == 0 ? 0 : first_variant + column - 1;
        map.values.back().push_back(100 * spread_of(errors[variant][row][m]).median);
      }
    }
    result.heat_maps.push_back(map);
  }
}

ExperimentResult study_robustness(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const int thinned = context.quick ? 2 : 1;
  const DriveSettings usual = usual_drive(context.quick, "kitchen", 1);
  const double rate = usual.frame_rate / thinned;
  std::vector<int> seeds = context.seeds;
  seeds.resize(std::min<std::size_t>(context.quick ? 1 : 2, seeds.size()));
  result.seeds = seeds;
  const std::vector<double> noise =
      context.quick ? std::vector<double>{0, 0.05} : std::vector<double>{0, 0.05, 0.1};
  const std::vector<RobustnessPlane> planes = robustness_planes(context.quick, rate);
  result.settings = {{"scene", "kitchen"},
                     {"seconds", usual.seconds},
                     {"frame_rate_hz", rate},
                     {"noise", "random_walk, 10 Hz"}};
  ResultTable table{
      "Robustness",
      {"changed", "value", "odometry noise cm", "mapper", "seed", "pose error cm", "odometry's error cm"},
      {}};
  std::vector<std::pair<std::string, double>> variants = {{"nothing", 0}};
  for (const RobustnessPlane& plane : planes)
    for (std::size_t i = 1; i < plane.columns.size(); ++i)
      variants.emplace_back(plane.column.label + ", " + plane.column.unit, plane.columns[i]);
  RobustnessErrors errors(variants.size(), {noise.size(), std::vector<std::vector<double>>(4)});
  int failed[4] = {0, 0, 0, 0}, cells = 0;
  for (const int seed : seeds) {
    const Drive drive = every_nth(*drives.drive(usual_drive(context.quick, "kitchen", seed)), thinned);
    std::vector<Drive> changed = {drive};
    for (const RobustnessPlane& plane : planes)
      for (std::size_t i = 1; i < plane.columns.size(); ++i)
        changed.push_back(plane.change(drive, plane.columns[i]));
    std::vector<GridCase> cases;
    for (const Drive& one : changed)
      for (const double sigma : noise) {
        cases.push_back({"", &one, {}, seed});
        if (sigma > 0)
          cases.back().set = {"odometry.noise.mode=random_walk",
                              fmt::format("odometry.noise.sigma={}", sigma)};
      }
    const std::vector<GridErrors> found = run_grid(cases);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::size_t variant = i / noise.size(), row = i % noise.size();
      const std::vector<double> e = grid_errors(found[i]);
      ++cells;
      for (std::size_t m = 0; m < 4; ++m) {
        errors[variant][row][m].push_back(e[m]);
        failed[m] += e[m] < found[i].odometry ? 0 : 1;
        table.rows.push_back({variants[variant].first, variants[variant].second, number(100 * noise[row]),
                              grid_methods[m], seed, number(100 * e[m]), number(100 * found[i].odometry)});
      }
    }
    context.progress(static_cast<double>(cells) / static_cast<double>(found.size() * seeds.size()));
  }
  std::size_t first_variant = 1;
  for (const RobustnessPlane& plane : planes) {
    add_heat_maps(plane, first_variant, noise, errors, result);
    first_variant += plane.columns.size() - 1;
  }
  result.tables = {table};
  const auto fewest = *std::min_element(std::begin(failed), std::end(failed));
  std::string best;
  for (std::size_t m = 0; m < 4; ++m)
    if (failed[m] == fewest) best += (best.empty() ? "" : " and ") + std::string(grid_methods[m]);
  result.finding = fmt::format(
      "No better than the odometry they were given are thesis FastSLAM in {} of {} cells, modern FastSLAM in "
      "{}, thesis "
      "ICP in {} and modern ICP in {}; most is borne by {}.",
      failed[0], cells, failed[1], failed[2], failed[3], best);
  return result;
}

}  // namespace

Experiment robustness_experiment(const SharedDrives& drives) {
  return {"robustness", "Odometry noise, texture, frame rate and light", "",
          [drives](const StudyContext& context) { return study_robustness(context, *drives); }};
}

}  // namespace lcmslam
