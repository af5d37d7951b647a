// Thesis, figure 2.10: Gaussian noise with a sigma of 2 cm added to the odometry's path. How much of the
// error is left in FastSLAM's path? The same noise on the increments, where errors add up, is the harder
// case.

#include <fmt/format.h>
#include <cmath>

#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

struct NoisyPath {
  std::string mode, preset;
  int seed = 0;
  MappingRun run;
};

ExperimentResult study_path_noise(const StudyContext& context, DriveStore& drives) {
  constexpr double sigma = 0.02;  // m
  constexpr int seeds = 20, quick_seeds = 2;
  ExperimentResult result;
  const int drive_seed = context.seeds.front();
  const auto drive = drives.drive(usual_drive(context.quick, "kitchen", drive_seed));
  result.settings = {
      {"scene", "kitchen"}, {"seconds", drive->seconds}, {"sigma_m", sigma}, {"drive_seed", drive_seed}};
  std::vector<NoisyPath> paths;
  for (const char* mode : {"white", "random_walk"})
    for (const char* preset : {"thesis", "modern"})
      for (int seed = 1; seed <= (context.quick ? quick_seeds : seeds); ++seed)
        paths.push_back({mode, preset, seed, {}});
  for (int seed = 1; seed <= (context.quick ? quick_seeds : seeds); ++seed) result.seeds.push_back(seed);
  run_side_by_side(paths.size(), [&](std::size_t i) {
    MapperChoice choice;
    choice.preset = paths[i].preset;
    choice.icp = false;
    choice.seed = paths[i].seed;
    choice.set = {"odometry.noise.mode=" + paths[i].mode, fmt::format("odometry.noise.sigma={}", sigma)};
    paths[i].run = map_drive(*drive, choice);
  });
  MapperChoice clean;
  clean.icp = clean.fastslam = false;
  const Trajectory original = map_drive(*drive, clean).odometry;

  ResultTable table{"Path error before and after FastSLAM",
                    {"noise", "preset", "seed", "noisy odometry cm", "FastSLAM cm"},
                    {}};
  Chart chart{"Path error by seed", {"seed", ""}, {"path error", "cm"}, {}, false};
  std::map<std::string, std::vector<double>> before, after;
  for (const NoisyPath& path : paths) {
    const std::string name = path.mode + ", " + path.preset;
    before[name].push_back(path_error(drive->truth, path.run.odometry));
    after[name].push_back(path_error(drive->truth, path.run.fastslam));
    table.rows.push_back({path.mode, path.preset, path.seed, number(100 * before[name].back()),
                          number(100 * after[name].back())});
    if (path.seed != 1 || path.preset != "thesis") continue;
    Chart paths_chart{
        "Original, noisy and corrected path, " + path.mode + " noise", {"x", "m"}, {"y", "m"}, {}, true};
    paths_chart.series = {
        path_series("truth", drive->truth),
        path_series("original odometry", original, fit_to_truth(drive->truth, original)),
        path_series("noisy odometry", path.run.odometry, fit_to_truth(drive->truth, path.run.odometry)),
        path_series("FastSLAM, thesis", path.run.fastslam, fit_to_truth(drive->truth, path.run.fastslam))};
    result.charts.push_back(paths_chart);
  }
  for (const auto& [name, errors] : after) {
    ChartSeries series{name + ": FastSLAM", ChartSeries::Mark::dots, {}, {}, {}, {}};
    for (std::size_t i = 0; i < errors.size(); ++i) {
      series.x.push_back(static_cast<double>(i + 1));
      series.y.push_back(100 * errors[i]);
    }
    chart.series.push_back(series);
  }
  for (const char* mode : {"white", "random_walk"}) {
    ChartSeries series{std::string(mode) + ": noisy odometry", ChartSeries::Mark::dots, {}, {}, {}, {}};
    const auto& errors = before[std::string(mode) + ", thesis"];
    for (std::size_t i = 0; i < errors.size(); ++i) {
      series.x.push_back(static_cast<double>(i + 1));
      series.y.push_back(100 * errors[i]);
    }
    chart.series.push_back(series);
  }
  result.charts.push_back(chart);
  result.tables = {table};
  int better = 0, all = 0;
  for (const auto& [name, errors] : after)
    for (std::size_t i = 0; name.find("thesis") != std::string::npos && i < errors.size(); ++i) {
      better += errors[i] < before[name][i] ? 1 : 0;
      ++all;
    }
  result.agreement = better == all      ? Agreement::agrees
                     : 2 * better > all ? Agreement::agrees_in_part
                                        : Agreement::differs;
  result.finding = fmt::format(
      "White noise leaves the odometry at {}, and the thesis's FastSLAM at {}, the modern one at {}; noise "
      "that "
      "adds up at {}, and these at {} and {}. The thesis's filter is better than its odometry in {} of {} "
      "runs.",
      in_words(before["white, thesis"], 100, "cm"), in_words(after["white, thesis"], 100, "cm"),
      in_words(after["white, modern"], 100, "cm"), in_words(before["random_walk, thesis"], 100, "cm"),
      in_words(after["random_walk, thesis"], 100, "cm"), in_words(after["random_walk, modern"], 100, "cm"),
      better, all);
  return result;
}

}  // namespace

Experiment path_noise_experiment(const SharedDrives& drives) {
  return {"path-noise", "Noise added to the path", "figure 2.10",
          [drives](const StudyContext& context) { return study_path_noise(context, *drives); }};
}

}  // namespace lcmslam
