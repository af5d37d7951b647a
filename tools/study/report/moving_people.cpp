// Future work of the thesis: dynamic environments. A person crosses before the robot all the time.

#include <fmt/format.h>
#include <cmath>

#include "tools/study/report/image_changes.hpp"
#include "tools/study/report/judgements.hpp"
#include "tools/study/report/map_pictures.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/preset_grid.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

ExperimentResult study_moving_people(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "", 1);
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  result.seeds = seeds;
  result.settings = {{"scene", "kitchen"},
                     {"seconds", usual.seconds},
                     {"frame_rate_hz", usual.frame_rate},
                     {"person", "pillar of 0.25 m radius and 1.75 m height, 2 m ahead, 0.8 m/s across"}};
  ResultTable table{
      "A person crosses before the robot",
      {"mapper", "seed", "pose error alone cm", "with her cm", "map off the surface alone cm", "with her cm"},
      {}};
  std::vector<std::vector<double>> alone(4), with(4);
  for (const int seed : seeds) {
    const auto drive = drives.drive(usual_drive(context.quick, "kitchen", seed));
    const Drive changed = with_images(*drive, with_person(*drive));
    if (seed == seeds.front()) {
      const Utime middle = changed.frames[changed.frames.size() / 2].utime;
      result.pictures.push_back(MapPictures(context.work, "person")
                                    .add(colour_image(changed, middle), "image",
                                         "What the camera sees of her",
                                         "The kitchen with a checked pillar of a person's size in the way."));
    }
    const auto errors = run_grid({{"alone", drive.get(), {}, seed}, {"with her", &changed, {}, seed}});
    for (std::size_t m = 0; m < 4; ++m) {
      const auto map_of = [&](const GridErrors& e) { return m < 2 ? e.fastslam_map[m] : e.icp_map[m - 2]; };
      alone[m].push_back(grid_errors(errors[0])[m]);
      with[m].push_back(grid_errors(errors[1])[m]);
      table.rows.push_back({grid_methods[m], seed, number(100 * alone[m].back()),
                            number(100 * with[m].back()), number(100 * map_of(errors[0])),
                            number(100 * map_of(errors[1]))});
    }
  }
  Chart chart{"Pose error alone and with a person crossing",
              {"people before the robot", ""},
              {"pose error", "cm", true},
              {},
              false};
  for (std::size_t m = 0; m < 4; ++m)
    chart.series.push_back(spread_series(grid_methods[m], {0, 1}, {alone[m], with[m]}, 100));
  result.charts = {chart};
  result.tables = {table};
  std::string words;
  std::vector<PersonErrors> mappers;
  for (std::size_t m = 0; m < 4; ++m) {
    words += fmt::format("{}{}: {} instead of {}", m == 0 ? "" : "; ", grid_methods[m],
                         in_words(with[m], 100, "cm"), in_words(alone[m], 100, "cm"));
    mappers.push_back({grid_methods[m], alone[m], with[m]});
  }
  result.finding = fmt::format("With a person crossing, {}; {}.", words, worst_with_person(mappers));
  return result;
}

ExperimentResult study_presets(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "", 1);
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  result.seeds = seeds;
  result.settings = {{"seconds", usual.seconds}, {"frame_rate_hz", usual.frame_rate}};
  ResultTable table{
      "Thesis preset against modern preset",
      {"scene", "mapper", "seed", "pose error cm", "odometry's error cm", "map off the surface cm"},
      {}};
  Chart chart{"Pose error by scene",
              {"scene", "", false, {"kitchen", "table", "office"}},
              {"pose error", "cm", true},
              {},
              false};
  std::vector<std::vector<std::vector<double>>> errors(4);
  int wins[2] = {0, 0}, beaten_by_wheels[4] = {0, 0, 0, 0}, all = 0;
  for (const char* scene : {"kitchen", "table", "office"}) {
    for (auto& method : errors) method.emplace_back();
    std::vector<std::shared_ptr<const Drive>> driven;
    std::vector<GridCase> cases;
    for (const int seed : seeds) {
      driven.push_back(drives.drive(usual_drive(context.quick, scene, seed)));
      cases.push_back({scene, driven.back().get(), {}, seed});
    }
    const std::vector<GridErrors> found_errors = run_grid(cases);
    for (std::size_t n = 0; n < seeds.size(); ++n) {
      const int seed = seeds[n];
      const GridErrors& e = found_errors[n];
      const std::vector<double> found = grid_errors(e);
      ++all;
      for (std::size_t m = 0; m < 4; ++m) {
        errors[m].back().push_back(found[m]);
        beaten_by_wheels[m] += found[m] < e.odometry ? 0 : 1;
        table.rows.push_back({scene, grid_methods[m], seed, number(100 * found[m]), number(100 * e.odometry),
                              number(100 * (m < 2 ? e.fastslam_map[m] : e.icp_map[m - 2]))});
      }
      wins[0] += found[1] < found[0] ? 1 : 0;
      wins[1] += found[3] < found[2] ? 1 : 0;
    }
  }
  for (std::size_t m = 0; m < 4; ++m) {
    chart.series.push_back(spread_series(grid_methods[m], {1, 2, 3}, errors[m], 100));
    chart.series.back().mark = ChartSeries::Mark::dots;  // nothing lies between two scenes
  }
  result.charts = {chart};
  result.tables = {table};
  result.finding = fmt::format(
      "The modern preset's pose is nearer to the truth than the thesis's in {} of {} drives by FastSLAM and "
      "in {} by "
      "ICP; no better than the wheels alone are thesis FastSLAM in {}, modern FastSLAM in {}, thesis ICP in "
      "{} and "
      "modern ICP in {}.",
      wins[0], all, wins[1], beaten_by_wheels[0], beaten_by_wheels[1], beaten_by_wheels[2],
      beaten_by_wheels[3]);
  return result;
}

}  // namespace

Experiment moving_people_experiment(const SharedDrives& drives) {
  return {"moving-people", "A person crosses before the robot", "future work: dynamic environments",
          [drives](const StudyContext& context) { return study_moving_people(context, *drives); }};
}

Experiment presets_experiment(const SharedDrives& drives) {
  return {"presets", "Thesis preset against modern preset", "",
          [drives](const StudyContext& context) { return study_presets(context, *drives); }};
}

}  // namespace lcmslam
