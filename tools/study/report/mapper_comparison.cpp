// Thesis, chapter 4 and table 4.1: FastSLAM against 6-D SLAM on the same recordings: how near maps are to the
// true surfaces, how dense, how much of what was seen they hold, how well the pose is known, and what becomes
// of that with noisy wheels and without any. Each claim of table 4.1 is tested by these numbers.

#include <fmt/format.h>
#include <cmath>

#include <lcmslam/runtime/machine.hpp>
#include "tools/study/report/map_pictures.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

struct Condition {
  std::string name;
  std::string noise;        ///< odometry.noise.sigma, m; empty: none
  double wheels_until = 1;  ///< share of the drive
};
/// The last one is without odometry. Quick: three of them.
std::vector<Condition> conditions_for(bool quick) {
  const Condition as_it_is{"wheels as they are", "", 1}, noise{"5 cm of noise a draw", "0.05", 1},
      none{"no wheels at all", "", 0};
  if (quick) return {as_it_is, noise, none};
  return {
      as_it_is, {"2 cm of noise a draw", "0.02", 1}, noise, {"wheels lost after a third", "", 1.0 / 3}, none};
}

/// What one mapper made under one condition.
struct MapFigures {
  double pose = 0, odometry = 0;           ///< ATE RMSE, m; NaN without a path
  double tracked = 0;                      ///< share of the frames with a pose that is not lost; NaN where
  int restarts = 0;                        ///< a new map was begun
  double first_half = 0, second_half = 0;  ///< RMS of the pose error in the frame of the first pose, m
  double off = 0, off_p90 = 0;             ///< of the map from true surfaces, m
  double points = 0, density = 0;          ///< a square metre of what the map covers
  double covered = 0;
  double megabytes = 0;
  double inside = 0;  ///< share of the poses that err less than their own 95 % bound
  double moved = 0;   ///< of poses by corrections of the graph, at most, m
};

/// The pose's error, and what it says of it, where the first pose makes the map, in the two halves of the
/// drive.
void measure_growth(const Trajectory& truth, const Trajectory& path, MapFigures& figures) {
  EvaluationSettings settings;
  settings.association = Association::interpolate_truth;
  settings.alignment = Alignment::first_pose;
  double squares[2] = {0, 0}, counts[2] = {0, 0};
  figures.first_half = figures.second_half = figures.inside = std::nan("");
  if (path.size() < 4) return;
  const TrajectoryReport report = evaluate(truth, path, settings);
  const std::vector<MatchedPose>& matches = report.matches;
  if (report.consistency) figures.inside = report.consistency->inside;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::size_t half = 2 * i / matches.size();
    squares[half] +=
        (matches[i].T_world_truth.translation() - matches[i].T_world_estimate.translation()).squaredNorm();
    counts[half] += 1;
  }
  figures.first_half = std::sqrt(squares[0] / counts[0]);
  figures.second_half = std::sqrt(squares[1] / counts[1]);
}

double farthest_correction(const MappingRun& run) {
  double farthest = 0;
  for (const StampedPose& pose : run.icp_final)
    if (const auto before = pose_at(run.icp, pose.utime))
      farthest = std::max(farthest, (before->translation() - pose.T_world_body.translation()).norm());
  return farthest;
}

MapFigures figures_of(const Drive& drive, const SeenSurface& seen, const MappingRun& run, bool fastslam) {
  MapFigures figures;
  const Trajectory& path = fastslam ? run.fastslam : run.icp;
  const auto places = fastslam ? places_of(run.landmarks) : places_of(run.cloud);
  const int lost = fastslam ? run.fastslam_lost : run.icp_lost;
  figures.pose = path_error(drive.truth, path);
  figures.odometry = path_error(drive.truth, run.odometry);
  figures.restarts = fastslam ? run.fastslam_restarts : run.icp_restarts;
  figures.tracked = figures.restarts > 0 ? std::nan("")
                                         : (static_cast<double>(path.size()) - lost) /
                                               static_cast<double>(drive.frames.size());
  measure_growth(drive.truth, path, figures);
  const Eigen::Isometry3d T = fit_to_truth(drive.truth, path);
  const auto distances = surface_distances(drive, T, places, 5000);
  figures.off = quantile_of(distances, 0.5);
  figures.off_p90 = quantile_of(distances, 0.9);
  figures.points = static_cast<double>(places.size());
  figures.covered = coverage(seen, T, places);
  const double area =
      figures.covered * static_cast<double>(seen.cells.size()) * SeenSurface::side * SeenSurface::side;
  figures.density = area > 0 ? figures.points / area : std::nan("");
  const auto bytes = run.map_bytes.find(fastslam ? "fastslam" : "icp");
  figures.megabytes = bytes == run.map_bytes.end() ? 0 : 1e-6 * static_cast<double>(bytes->second);
  figures.moved = fastslam ? std::nan("") : farthest_correction(run);
  return figures;
}

std::vector<std::string> settings_of(const Condition& condition, bool thesis) {
  std::vector<std::string> set;
  if (!condition.noise.empty())
    set = {"odometry.noise.mode=random_walk", "odometry.noise.sigma=" + condition.noise};
  // Without odometry the thesis registers by algorithm 3.2, which was made for that.
  if (thesis && condition.wheels_until == 0) set.emplace_back("icp.variant=alternating");
  return set;
}

// By preset, condition, mapper (0: FastSLAM, 1: ICP) and seed.
using Figures = std::map<std::string, std::vector<std::array<std::vector<MapFigures>, 2>>>;

std::vector<double> values_of(const std::vector<MapFigures>& figures, double MapFigures::*value) {
  std::vector<double> values;
  values.reserve(figures.size());
  for (const MapFigures& f : figures) values.push_back(f.*value);
  return values;
}
double median_of(const std::vector<MapFigures>& figures, double MapFigures::*value) {
  return spread_of(values_of(figures, value)).median;
}

struct Claim {
  std::string text, measured;
  bool holds = false;
};

/// Table 4.1, claim by claim, by the runs of one preset.
std::vector<Claim> test_claims(const std::string& preset, const Figures& all) {
  const auto& runs = all.at(preset);
  const auto &landmarks = runs[0][0], &cloud = runs[0][1];
  const std::size_t no_wheels = runs.size() - 1;
  const auto median = [&](std::size_t condition, std::size_t mapper, double MapFigures::*value) {
    return median_of(runs[condition][mapper], value);
  };
  const auto words = [&](std::size_t condition, std::size_t mapper, double MapFigures::*value) {
    return in_words(values_of(runs[condition][mapper], value), 100, "cm");
  };
  const double sparse = median_of(landmarks, &MapFigures::density),
               dense = median_of(cloud, &MapFigures::density);
  const double growth_filter = median(0, 0, &MapFigures::second_half) / median(0, 0, &MapFigures::first_half);
  const double growth_icp = median(0, 1, &MapFigures::second_half) / median(0, 1, &MapFigures::first_half);
  const double filter_without = median(no_wheels, 0, &MapFigures::pose),
               icp_without = median(no_wheels, 1, &MapFigures::pose);
  const double filter_with = median(0, 0, &MapFigures::pose), icp_with = median(0, 1, &MapFigures::pose);
  std::vector<Claim> claims;
  claims.push_back({"FastSLAM's map is sparse, ICP's is dense",
                    fmt::format("{:.0f} landmarks and {:.0f} points a square metre", sparse, dense),
                    dense > 10 * sparse});
  claims.push_back({"FastSLAM's map is the more accurate",
                    "off the surface, half within: landmarks " + words(0, 0, &MapFigures::off) + ", points " +
                        words(0, 1, &MapFigures::off),
                    median(0, 0, &MapFigures::off) < median(0, 1, &MapFigures::off)});
  claims.push_back({"FastSLAM's pose is the more accurate",
                    "FastSLAM " + words(0, 0, &MapFigures::pose) + ", ICP " + words(0, 1, &MapFigures::pose),
                    filter_with < icp_with});
  claims.push_back(
      {"FastSLAM's error does not propagate, ICP's does",
       fmt::format("from the first to the second half of the drive the error grows {:.1f} and {:.1f} "
                   "times",
                   growth_filter, growth_icp),
       growth_filter < 1.5 && growth_icp > 1.5});
  claims.push_back({"FastSLAM tells how wrong it may be",
                    fmt::format("{:.0f} % of its poses err less than their 95 % bound",
                                100 * median(0, 0, &MapFigures::inside)),
                    median(0, 0, &MapFigures::inside) > 0.8});
  claims.push_back({"FastSLAM needs odometry",
                    "with wheels " + words(0, 0, &MapFigures::pose) + ", without " +
                        words(no_wheels, 0, &MapFigures::pose),
                    !(filter_without < 3 * filter_with)});
  claims.push_back({"ICP works without odometry",
                    "with wheels " + words(0, 1, &MapFigures::pose) + ", without " +
                        words(no_wheels, 1, &MapFigures::pose),
                    icp_without < 3 * icp_with});
  claims.push_back(
      {"ICP corrects the robot's pose only, never the map",
       fmt::format("poses are moved afterwards by {:.1f} cm at most", 100 * median(0, 1, &MapFigures::moved)),
       !(median(0, 1, &MapFigures::moved) > 1e-3)});
  return claims;
}

ExperimentResult study_mapper_comparison(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const DriveSettings usual = usual_drive(context.quick, "", 1);
  std::vector<int> seeds = context.seeds;
  if (context.quick) seeds.resize(std::min<std::size_t>(1, seeds.size()));
  result.seeds = seeds;
  result.settings = {{"scene", "kitchen"},
                     {"seconds", usual.seconds},
                     {"frame_rate_hz", usual.frame_rate},
                     {"noise", "random_walk"}};
  const std::vector<std::string> presets = {"thesis", "modern"};
  const std::vector<Condition> conditions = conditions_for(context.quick);
  Figures all;
  for (const std::string& preset : presets) all[preset].resize(conditions.size());
  ResultTable table{"Both mappers on the same drives",
                    {"preset", "odometry", "mapper", "seed", "pose error cm", "odometry's error cm",
                     "tracked %", "new maps", "off the surface, median cm", "90 % cm", "points",
                     "points a m2", "covered %", "published map MB"},
                    {}};
  for (const int seed : seeds) {
    const auto drive = drives.drive(usual_drive(context.quick, "kitchen", seed));
    const SeenSurface seen = seen_surface(*drive);
    std::vector<MappingRun> runs(presets.size() * conditions.size());
    run_side_by_side(runs.size(), [&](std::size_t i) {
      const Condition& condition = conditions[i % conditions.size()];
      MapperChoice choice;
      choice.preset = presets[i / conditions.size()];
      choice.seed = seed;
      choice.set = settings_of(condition, choice.preset == "thesis");
      runs[i] = condition.wheels_until < 1
                    ? map_drive(without_wheels(*drive, condition.wheels_until * drive->seconds, 1e9), choice)
                    : map_drive(*drive, choice);
    });
    for (std::size_t i = 0; i < runs.size(); ++i)
      for (const bool fastslam : {true, false}) {
        const std::string& preset = presets[i / conditions.size()];
        const std::size_t condition = i % conditions.size();
        const MapFigures f = figures_of(*drive, seen, runs[i], fastslam);
        all[preset][condition][fastslam ? 0 : 1].push_back(f);
        table.rows.push_back({preset, conditions[condition].name, fastslam ? "FastSLAM" : "ICP", seed,
                              number(100 * f.pose), number(100 * f.odometry), number(100 * f.tracked),
                              f.restarts, number(100 * f.off), number(100 * f.off_p90), f.points,
                              number(f.density), number(100 * f.covered), number(f.megabytes)});
      }
    for (std::size_t p = 0; p < presets.size() && seed == seeds.front(); ++p) {
      const MappingRun& run = runs[p * conditions.size()];
      for (const auto& [process, cpu] : run.cpu_seconds)
        result.timing[presets[p] + " " + process + ", CPU s a frame"] =
            cpu / static_cast<double>(drive->frames.size());
      if (std::isfinite(run.icp_megabytes))
        result.memory[presets[p] + " icp's map, bytes"] = std::llround(1e6 * run.icp_megabytes);
      for (const bool fastslam : {true, false}) {
        MapPictures pictures(context.work, "compare_" + presets[p] + (fastslam ? "_fastslam" : "_icp"));
        if (fastslam)
          pictures.landmarks = &run.landmarks;
        else
          pictures.cloud = &run.cloud;
        pictures.T_world_map = fit_to_truth(drive->truth, fastslam ? run.fastslam : run.icp);
        pictures.paths = {{"truth", {0, 0, 0}, drive->truth, Eigen::Isometry3d::Identity()}};
        pictures.add_views(result, fmt::format("The same drive by {}, {} preset",
                                               fastslam ? "FastSLAM" : "ICP", presets[p]));
      }
    }
  }
  result.memory["resident after all runs, bytes"] = resident_bytes();
  Chart chart{"Pose error as odometry gets worse",
              {"noise added a draw", "cm"},
              {"pose error", "cm", true},
              {},
              false};
  for (const std::string& preset : presets)
    for (std::size_t mapper = 0; mapper < 2; ++mapper) {
      std::vector<double> noise;
      std::vector<std::vector<double>> values;
      for (std::size_t condition = 0; condition < conditions.size(); ++condition) {
        if (conditions[condition].wheels_until < 1) continue;
        noise.push_back(conditions[condition].noise.empty() ? 0
                                                            : 100 * std::stod(conditions[condition].noise));
        values.push_back(values_of(all[preset][condition][mapper], &MapFigures::pose));
      }
      chart.series.push_back(
          spread_series((mapper == 0 ? "FastSLAM, " : "ICP, ") + preset, noise, values, 100));
    }
  result.charts = {chart};
  ResultTable claims{"Table 4.1, claim by claim", {"claim", "preset", "measured", "holds"}, {}};
  std::map<std::string, int> held;
  int count = 0;
  for (const std::string& preset : presets) {
    const auto tested = test_claims(preset, all);
    count = static_cast<int>(tested.size());
    for (const Claim& claim : tested) {
      claims.rows.push_back({claim.text, preset, claim.measured, claim.holds ? "holds" : "does not hold"});
      held[preset] += claim.holds ? 1 : 0;
    }
  }
  result.tables = {claims, table};
  result.agreement = held["thesis"] == count       ? Agreement::agrees
                     : 2 * held["thesis"] >= count ? Agreement::agrees_in_part
                                                   : Agreement::differs;
  const auto pose = [&](const char* preset, std::size_t mapper) {
    return in_words(values_of(all[preset][0][mapper], &MapFigures::pose), 100, "cm");
  };
  result.finding = fmt::format(
      "Of the {} claims of table 4.1 that were tested {} hold with the thesis's preset and {} with the "
      "modern one; "
      "FastSLAM's pose errs by {} and ICP's by {} with the thesis's preset, by {} and {} with the modern "
      "one.",
      count, held["thesis"], held["modern"], pose("thesis", 0), pose("thesis", 1), pose("modern", 0),
      pose("modern", 1));
  return result;
}

}  // namespace

Experiment mapper_comparison_experiment(const SharedDrives& drives) {
  return {"mappers", "FastSLAM against 6-D SLAM", "chapter 4, figures 4.1, 4.3, 4.4 and table 4.1",
          [drives](const StudyContext& context) { return study_mapper_comparison(context, *drives); }};
}

}  // namespace lcmslam
