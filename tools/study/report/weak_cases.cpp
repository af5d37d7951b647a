// Thesis, figure 4.2, and its opposite: where there is little geometry ICP fails and FastSLAM does not, and
// where there is little to see FastSLAM fails and ICP does not. A bare corridor is the one, the kitchen in
// the dark (depth cameras bring their own light) the other; the kitchen as it is stands beside them.

#include <fmt/format.h>
#include <cmath>

#include "tools/study/report/image_changes.hpp"
#include "tools/study/report/judgements.hpp"
#include "tools/study/report/map_pictures.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

struct WeakCase {
  std::string name, scene;
  double light = 1;
  bool whole = false;  ///< all of the path
};

ExperimentResult study_weak_cases(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "", 1);
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  result.seeds = seeds;
  std::vector<WeakCase> cases = {
      {"kitchen", "kitchen"}, {"bare corridor", "corridor"}, {"kitchen in the dark", "kitchen", 0.03}};
  if (!context.quick) cases.push_back({"once around the table", "table", 1, true});
  const std::vector<std::string> presets = {"thesis", "modern"};
  result.settings = {
      {"seconds", usual.seconds}, {"frame_rate_hz", usual.frame_rate}, {"light_in_the_dark", 0.03}};
  ResultTable table{"Little geometry, little to see",
                    {"case", "preset", "seed", "features with depth a frame", "FastSLAM's pose error cm",
                     "ICP's pose error cm", "odometry's error cm"},
                    {}};
  // By case and preset.
  std::vector<std::vector<std::vector<double>>> filter(cases.size(), {{}, {}}), icp = filter, wheels = filter;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    Chart chart{"Paths: " + cases[c].name, {"x", "m"}, {"y", "m"}, {}, true};
    std::vector<Drive> driven;
    for (const int seed : seeds) {
      DriveSettings settings = usual_drive(context.quick, cases[c].scene, seed);
      if (cases[c].whole) settings.seconds = 0;
      const auto lit = drives.drive(settings);
      driven.push_back(cases[c].light < 1 ? with_images(*lit, dimmed(cases[c].light)) : *lit);
    }
    std::vector<MappingRun> all(2 * seeds.size());
    run_side_by_side(all.size(), [&](std::size_t i) {
      MapperChoice choice;
      choice.preset = presets[i % 2];
      choice.seed = seeds[i / 2];
      all[i] = map_drive(driven[i / 2], choice);
    });
    for (std::size_t n = 0; n < seeds.size(); ++n) {
      const int seed = seeds[n];
      const Drive& drive = driven[n];
      const MappingRun* runs = &all[2 * n];
      double features = 0;
      for (const FeatureFrame& frame : drive.frames)
        for (const Feature& f : frame.features)
          features += f.kind == MeasurementKind::point ? 1.0 / static_cast<double>(drive.frames.size()) : 0;
      for (std::size_t p = 0; p < 2; ++p) {
        filter[c][p].push_back(path_error(drive.truth, runs[p].fastslam));
        icp[c][p].push_back(path_error(drive.truth, runs[p].icp));
        wheels[c][p].push_back(path_error(drive.truth, runs[p].odometry));
        table.rows.push_back({cases[c].name, presets[p], seed, number(features),
                              number(100 * filter[c][p].back()), number(100 * icp[c][p].back()),
                              number(100 * wheels[c][p].back())});
        if (seed != seeds.front()) continue;
        const Trajectory &f = runs[p].fastslam, &i = runs[p].icp;
        chart.series.push_back(path_series("FastSLAM, " + presets[p], f, fit_to_truth(drive.truth, f)));
        chart.series.push_back(path_series("ICP, " + presets[p], i, fit_to_truth(drive.truth, i)));
        if (p == 0) chart.series.insert(chart.series.begin(), path_series("truth", drive.truth));
        if (c != 1 || p != 0) continue;
        MapPictures pictures(context.work, "corridor_icp");
        pictures.cloud = &runs[p].cloud;
        pictures.T_world_map = fit_to_truth(drive.truth, i);
        pictures.paths = {{"truth", {0, 0, 0}, drive.truth, Eigen::Isometry3d::Identity()},
                          {"ICP", {178, 114, 0}, i, pictures.T_world_map}};
        pictures.add_views(result, "The bare corridor by the thesis's ICP");
      }
    }
    result.charts.push_back(chart);
    context.progress(static_cast<double>(c + 1) / static_cast<double>(cases.size()));
  }
  result.tables = {table};
  std::vector<WeakErrors> bare;  // the table too, which figure 4.2 shows
  for (std::size_t c = 1; c < cases.size(); ++c)
    if (cases[c].light == 1) bare.push_back({cases[c].name, filter[c][0], icp[c][0]});
  const Judgement judgement = judge_weak_cases(bare, {cases[2].name, filter[2][0], icp[2][0]});
  result.agreement = judgement.agreement;
  std::string words;
  for (std::size_t c = 1; c < cases.size(); ++c)
    words += fmt::format("{}{} the thesis's FastSLAM errs by {} and its ICP by {} (modern: {} and {})",
                         c > 1 ? "; " : "", cases[c].name + ":", in_words(filter[c][0], 100, "cm"),
                         in_words(icp[c][0], 100, "cm"), in_words(filter[c][1], 100, "cm"),
                         in_words(icp[c][1], 100, "cm"));
  result.finding = words + ". " + judgement.finding;
  return result;
}

}  // namespace

Experiment weak_cases_experiment(const SharedDrives& drives) {
  return {"weak-cases", "Where ICP fails and FastSLAM does not, and the opposite", "figure 4.2",
          [drives](const StudyContext& context) { return study_weak_cases(context, *drives); }};
}

}  // namespace lcmslam
