// Thesis, figures 3.5, 3.6 and 3.12 to 3.14: kitchen and office by ICP with the small-angle estimator, and
// how far the map's points lie from the true surfaces. Beside it the modern mapper.

#include <fmt/format.h>
#include <cmath>

#include "tools/study/report/map_pictures.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

ExperimentResult study_dense_maps(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "", 1);
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  result.seeds = seeds;
  result.settings = {
      {"seconds", usual.seconds}, {"frame_rate_hz", usual.frame_rate}, {"solver", "small_angle"}};
  ResultTable table{
      "Dense maps by ICP",
      {"scene", "preset", "seed", "points", "median off the surface cm", "95 % cm",
       "seen surface that the map has %", "pose error cm", "odometry's error cm", "frames lost", "new maps"},
      {}};
  std::map<std::string, std::vector<double>> off, error, wheels;
  for (const char* scene : {"kitchen", "office"}) {
    Chart chart{"Points of the map off the true surfaces, " + std::string(scene),
                {"distance from the nearest true surface", "cm"},
                {"points nearer than that", "%"},
                {},
                false};
    const std::vector<std::string> presets = {"thesis", "modern"};
    std::vector<std::shared_ptr<const Drive>> driven;
    driven.reserve(seeds.size());
    for (const int seed : seeds) driven.push_back(drives.drive(usual_drive(context.quick, scene, seed)));
    std::vector<MappingRun> all(presets.size() * seeds.size());
    run_side_by_side(all.size(), [&](std::size_t i) {
      MapperChoice choice;
      choice.preset = presets[i % 2];
      choice.fastslam = false;
      choice.seed = seeds[i / 2];
      all[i] = map_drive(*driven[i / 2], choice);
    });
    for (std::size_t n = 0; n < seeds.size(); ++n) {
      const int seed = seeds[n];
      const auto& drive = driven[n];
      const SeenSurface seen = seen_surface(*drive);
      for (std::size_t i = 0; i < 2; ++i) {
        const MappingRun& run = all[2 * n + i];
        const Trajectory& path = run.icp_final.empty() ? run.icp : run.icp_final;
        const Eigen::Isometry3d T = fit_to_truth(drive->truth, path);
        const auto places = places_of(run.cloud);
        const auto distances = surface_distances(*drive, T, places);
        off[presets[i]].push_back(quantile_of(distances, 0.5));
        error[presets[i]].push_back(path_error(drive->truth, path));
        wheels[presets[i]].push_back(path_error(drive->truth, run.odometry));
        table.rows.push_back({scene, presets[i], seed, places.size(), number(100 * off[presets[i]].back()),
                              number(100 * quantile_of(distances, 0.95)),
                              number(100 * coverage(seen, T, places)), number(100 * error[presets[i]].back()),
                              number(100 * wheels[presets[i]].back()), run.icp_lost, run.icp_restarts});
        if (seed != seeds.front()) continue;
        chart.series.push_back(distribution_series(presets[i] + " preset", distances, 100));
        MapPictures pictures(context.work, "dense_" + std::string(scene) + "_" + presets[i]);
        pictures.cloud = &run.cloud;
        pictures.T_world_map = T;
        pictures.paths = {{"truth", {0, 0, 0}, drive->truth, Eigen::Isometry3d::Identity()},
                          {"ICP", {178, 114, 0}, path, T}};
        pictures.add_views(result, "The " + std::string(scene) + " by ICP, " + presets[i] + " preset");
      }
    }
    result.charts.push_back(chart);
    context.progress(std::string(scene) == "kitchen" ? 0.5 : 1);
  }
  result.tables = {table};
  const double by_icp = median_or_lost(error["thesis"]), by_wheels = median_or_lost(wheels["thesis"]);
  const std::string verdict = !std::isfinite(by_icp) ? "is lost"
                              : by_icp < by_wheels   ? "improves on it"
                                                     : "makes it worse";
  result.agreement = by_icp < by_wheels ? Agreement::agrees : Agreement::differs;
  result.finding = fmt::format(
      "By the thesis's frustum ICP half of the points lie within {} of a true surface and the path errs by "
      "{} "
      "(odometry: {}, so the thesis's ICP {}); by the modern mapper within {}, and by {}.",
      in_words(off["thesis"], 100, "cm"), in_words(error["thesis"], 100, "cm"),
      in_words(wheels["thesis"], 100, "cm"), verdict, in_words(off["modern"], 100, "cm"),
      in_words(error["modern"], 100, "cm"));
  return result;
}

}  // namespace

Experiment dense_maps_experiment(const SharedDrives& drives) {
  return {"dense-maps", "Kitchen and office by ICP", "figures 3.5, 3.6 and 3.12 to 3.14",
          [drives](const StudyContext& context) { return study_dense_maps(context, *drives); }};
}

}  // namespace lcmslam
