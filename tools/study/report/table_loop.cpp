// Thesis, figures 2.6 to 2.9: around the table and back to the start. What is seen first is seen again last;
// how far apart do its two pictures in the map lie, by FastSLAM and by the wheels alone?

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "tools/study/filter_study.hpp"
#include "tools/study/report/map_pictures.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

/// The features with depth of the first or the last frames, from above, each placed by the path's pose.
ChartSeries features_seen(const std::string& name, const Drive& drive, const Trajectory& path,
                          const Eigen::Isometry3d& T_world_path, bool last) {
  constexpr std::size_t frames = 3, most = 400;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < frames && i < drive.frames.size(); ++i) {
    const FeatureFrame& frame = last ? drive.frames[drive.frames.size() - 1 - i] : drive.frames[i];
    const auto T = pose_at(path, frame.utime);
    if (!T) continue;
    for (const Feature& f : frame.features)
      if (f.kind == MeasurementKind::point && points.size() < most)
        points.emplace_back((T_world_path * *T * frame.T_robot_camera * f.point.cast<double>()).head<2>());
  }
  return points_series(name, points);
}

Chart features_chart(const std::string& title, const Drive& drive, const Trajectory& path) {
  const Eigen::Isometry3d T = fit_to_truth(drive.truth, path);
  Chart chart{title, {"x", "m"}, {"y", "m"}, {}, true};
  chart.series = {path_series("path", path, T),
                  features_seen("features of the first frames", drive, path, T, false),
                  features_seen("features of the last frames", drive, path, T, true)};
  return chart;
}

ExperimentResult study_table_loop(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const double rate = usual_drive(context.quick, "table", 1).frame_rate;
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  result.seeds = seeds;
  result.settings = {{"scene", "table"}, {"frame_rate_hz", rate}};
  const std::vector<std::string> methods = {"odometry", "FastSLAM, thesis", "FastSLAM, modern"};
  std::map<std::string, std::vector<double>> apart;
  ResultTable table{"One thing seen first and last",
                    {"seed", "map", "things", "median apart cm", "90 % cm", "path error cm"},
                    {}};
  Chart chart{"One thing seen first and last",
              {"distance between both in the map", "cm"},
              {"things nearer than that", "%"},
              {},
              false};
  for (std::size_t n = 0; n < seeds.size(); ++n) {
    const auto drive = drives.drive({"table", seeds[n], 0, rate});
    std::vector<MappingRun> runs(2);
    run_side_by_side(2, [&](std::size_t i) {
      MapperChoice choice;
      choice.preset = i == 0 ? "thesis" : "modern";
      choice.icp = false;
      choice.seed = seeds[n];
      runs[i] = map_drive(*drive, choice);
    });
    const Trajectory* paths[] = {&runs[0].odometry, &runs[0].fastslam, &runs[1].fastslam};
    for (std::size_t m = 0; m < methods.size(); ++m) {
      std::vector<double> distances = reunion_distances(drive->frames, drive->truth, *paths[m]);
      std::sort(distances.begin(), distances.end());
      apart[methods[m]].push_back(quantile_of(distances, 0.5));
      table.rows.push_back({seeds[n], methods[m], distances.size(), number(100 * apart[methods[m]].back()),
                            number(100 * quantile_of(distances, 0.9)),
                            number(100 * path_error(drive->truth, *paths[m]))});
      if (n > 0) continue;
      chart.series.push_back(distribution_series(methods[m], distances, 100));
      result.charts.push_back(features_chart("Around the table, by " + methods[m], *drive, *paths[m]));
      if (m == 0) continue;
      const MappingRun& run = runs[m - 1];
      const Eigen::Isometry3d T = fit_to_truth(drive->truth, run.fastslam);
      MapPictures pictures(context.work, "table_" + std::string(m == 1 ? "thesis" : "modern"));
      pictures.landmarks = &run.landmarks;
      pictures.T_world_map = T;
      pictures.paths = {{"truth", {0, 0, 0}, drive->truth, Eigen::Isometry3d::Identity()},
                        {"odometry", {0, 94, 213}, run.odometry, fit_to_truth(drive->truth, run.odometry)},
                        {"FastSLAM", {178, 114, 0}, run.fastslam, T}};
      pictures.add_views(result, "Around the table, " + methods[m]);
    }
    context.progress(static_cast<double>(n + 1) / static_cast<double>(seeds.size()));
  }
  result.charts.insert(result.charts.begin(), chart);
  result.tables = {table};
  const double by_wheels = spread_of(apart[methods[0]]).median,
               by_thesis = spread_of(apart[methods[1]]).median,
               by_modern = spread_of(apart[methods[2]]).median;
  result.agreement = by_thesis < 0.5 * by_wheels   ? Agreement::agrees
                     : by_modern < 0.5 * by_wheels ? Agreement::agrees_in_part
                                                   : Agreement::differs;
  result.finding = fmt::format(
      "Back at the start, what is seen again lies {} from where it was first by the wheels, {} by the "
      "thesis's "
      "FastSLAM and {} by the modern one: the thesis's filter {}.",
      in_words(apart[methods[0]], 100, "cm"), in_words(apart[methods[1]], 100, "cm"),
      in_words(apart[methods[2]], 100, "cm"),
      by_thesis < 0.5 * by_wheels ? "closes the loop as figures 2.7 and 2.8 show"
                                  : "takes away less than half of what the wheels err");
  return result;
}

}  // namespace

Experiment table_loop_experiment(const SharedDrives& drives) {
  return {"table-loop", "Around the table and back to the start", "figures 2.6 to 2.9",
          [drives](const StudyContext& context) { return study_table_loop(context, *drives); }};
}

}  // namespace lcmslam
