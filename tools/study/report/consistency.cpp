// Beyond the thesis: do the mappers err as much as they say? NEES of the published poses over seeds
// (consistency_study.hpp) in three scenes, modern preset; the thesis's filter has a covariance too.

#include "tools/study/consistency_study.hpp"

#include <fmt/format.h>
#include <cmath>

#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

ConsistencyRun nees_of(const std::string& scene, const std::string& mapper, const Drive& drive,
                       const BelievedPath& believed) {
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  ConsistencyRun run = consistency_run(drive.truth, believed, settings);
  run.scene = scene;
  run.channel = mapper;
  return run;
}

ChartSeries nees_by_time(const std::string& name, const std::vector<ConsistencyRun>& runs) {
  std::vector<double> seconds;
  std::vector<std::vector<double>> values;
  for (const ConsistencyRun& run : runs) {
    if (run.scene + ", " + run.channel != name) continue;
    for (std::size_t second = 0; second < run.nees.size(); ++second) {
      if (second >= values.size()) {
        values.emplace_back();
        seconds.push_back(static_cast<double>(second));
      }
      values[second].push_back(run.nees[second] / run.components);
    }
  }
  return spread_series(name, seconds, values, 1);
}

ExperimentResult study_nees(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  result.seeds = context.seeds;
  std::vector<std::string> scenes = {"kitchen", "table", "office"};
  if (context.quick) scenes.resize(1);
  result.settings = {{"scenes", scenes}, {"seconds", usual_drive(context.quick, "", 1).seconds}};
  std::vector<ConsistencyRun> runs;
  for (const std::string& scene : scenes)
    for (const int seed : context.seeds) {
      const auto drive = drives.drive(usual_drive(context.quick, scene, seed));
      MappingRun found[2];
      run_side_by_side(2, [&](std::size_t i) {
        MapperChoice choice;
        choice.preset = i == 0 ? "modern" : "thesis";
        choice.icp = i == 0;  // the thesis's ICP has no noise model
        choice.seed = seed;
        found[i] = map_drive(*drive, choice);
      });
      runs.push_back(nees_of(scene, "FastSLAM, modern", *drive, found[0].fastslam_believed));
      runs.push_back(nees_of(scene, "ICP, modern", *drive, found[0].icp_believed));
      runs.push_back(nees_of(scene, "FastSLAM, thesis", *drive, found[1].fastslam_believed));
    }
  ResultTable table{"NEES over the number of free components: 1 is honest",
                    {"scene", "mapper", "runs", "components", "mean", "median", "band from", "band to",
                     "seconds inside the band %", "above %", "above three times %", "poses left out"},
                    {}};
  Chart chart{"NEES over the number of components", {"time", "s"}, {"NEES", "", true}, {}, false};
  std::string words;
  int bold = 0, all = 0;
  for (const ConsistencyScore& s : consistency_scores(runs)) {
    const double d = s.components;
    table.rows.push_back({s.scene, s.channel, s.runs, s.components, number(s.mean / d), number(s.median / d),
                          number(s.low / d), number(s.high / d), number(100 * s.inside),
                          number(100 * s.above), number(100 * s.far_above), s.left_out});
    chart.series.push_back(nees_by_time(s.scene + ", " + s.channel, runs));
    words += fmt::format("{}{} in the {} {}", words.empty() ? "" : ", ", s.channel, s.scene,
                         s.runs > 0 ? fmt::format("{:.1f}", s.mean / d) : "not judged");
    bold += s.mean / d > 3 ? 1 : 0;
    ++all;
  }
  result.charts = {chart};
  result.tables = {table};
  result.finding = fmt::format(
      "Mean NEES over the number of components, 1 when honest: {}; {} of {} are bolder than "
      "three times.",
      words, bold, all);
  return result;
}

}  // namespace

Experiment consistency_experiment(const SharedDrives& drives) {
  return {"mapper-consistency", "Do the mappers err as much as they say?", "",
          [drives](const StudyContext& context) { return study_nees(context, *drives); }};
}

}  // namespace lcmslam
