// Beyond the thesis: the mappers are told a wrong calibration. What does an error of the mount, of the depth
// camera's place on the colour camera or of the focal length cost?

#include <fmt/format.h>
#include <cmath>

#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/preset_grid.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

struct WrongCalibration {
  std::string name, unit;
  std::vector<double> values, quick_values;
  RgbdCalibration (*wrong)(RgbdCalibration calibration, double value);
};

Eigen::Isometry3d turned(double degrees_of_turn, const Eigen::Vector3d& axis) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(degrees_of_turn * M_PI / 180, axis));
}

const std::vector<WrongCalibration> wrong_calibrations = {
    {"heading of the mount",
     "degrees",
     {0, 0.5, 1, 2, 4},
     {0, 2},
     [](RgbdCalibration c, double v) {
       c.T_robot_camera = turned(v, Eigen::Vector3d::UnitZ()) * c.T_robot_camera;
       return c;
     }},
    {"tilt of the mount",
     "degrees",
     {0, 0.5, 1, 2, 4},
     {0},
     [](RgbdCalibration c, double v) {
       c.T_robot_camera = c.T_robot_camera * turned(v, Eigen::Vector3d::UnitX());
       return c;
     }},
    {"depth camera turned on the colour camera",
     "degrees",
     {0, 0.5, 1, 2, 4},
     {0, 2},
     [](RgbdCalibration c, double v) {
       c.T_colour_depth = c.T_colour_depth * turned(v, Eigen::Vector3d::UnitY());
       return c;
     }},
    {"focal length of the colour camera", "%", {0, 0.5, 1, 2, 4}, {0, 2}, [](RgbdCalibration c, double v) {
       c.colour.fx *= 1 + 0.01 * v;
       c.colour.fy *= 1 + 0.01 * v;
       return c;
     }}};

ExperimentResult study_calibration(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  if (seeds.size() > 2) seeds.resize(2);
  result.seeds = seeds;
  result.settings = {
      {"scene", "kitchen"}, {"seconds", usual_drive(context.quick, "", 1).seconds}, {"preset", "modern"}};
  ResultTable table{"Pose error by calibration error",
                    {"wrong", "by", "unit", "seed", "FastSLAM's pose error cm", "ICP's pose error cm"},
                    {}};
  std::string words;
  for (const WrongCalibration& kind : wrong_calibrations) {
    const std::vector<double>& values = context.quick ? kind.quick_values : kind.values;
    std::vector<std::vector<double>> filter(values.size()), icp = filter;
    for (const int seed : seeds) {
      const auto drive = drives.drive(usual_drive(context.quick, "kitchen", seed));
      std::vector<std::array<double, 2>> errors(values.size());
      run_side_by_side(values.size(), [&](std::size_t i) {
        MapperChoice choice;
        choice.seed = seed;
        const Drive told = with_calibration(*drive, kind.wrong(drive->calibration, values[i]));
        const MappingRun run = map_drive(told, choice);
        errors[i] = {path_error(drive->truth, run.fastslam), path_error(drive->truth, run.icp)};
      });
      for (std::size_t i = 0; i < values.size(); ++i) {
        filter[i].push_back(errors[i][0]);
        icp[i].push_back(errors[i][1]);
        table.rows.push_back(
            {kind.name, values[i], kind.unit, seed, number(100 * errors[i][0]), number(100 * errors[i][1])});
      }
    }
    if (values.size() < 2) continue;
    Chart chart{
        "Wrong " + kind.name, {"error of the " + kind.name, kind.unit}, {"pose error", "cm"}, {}, false};
    chart.series = {spread_series("FastSLAM", values, filter, 100), spread_series("ICP", values, icp, 100)};
    result.charts.push_back(chart);
    words += fmt::format("{}{} by {:g} {}: {} and {}", words.empty() ? "" : "; ", kind.name, values.back(),
                         kind.unit, in_words(filter.back(), 100, "cm"), in_words(icp.back(), 100, "cm"));
    if (!words.empty() && &kind == &wrong_calibrations.front())
      words.insert(0, fmt::format("Well calibrated FastSLAM and ICP err by {} and {}; with a wrong ",
                                  in_words(filter.front(), 100, "cm"), in_words(icp.front(), 100, "cm")));
  }
  result.tables = {table};
  result.finding = words + ".";
  return result;
}

}  // namespace

Experiment calibration_experiment(const SharedDrives& drives) {
  return {"calibration", "Calibration error against pose error", "",
          [drives](const StudyContext& context) { return study_calibration(context, *drives); }};
}

}  // namespace lcmslam
