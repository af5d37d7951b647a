// Beyond the thesis: what grows with the way? Landmarks, points and keyframes of both mappers in laps of one
// room, where a lap shows nothing new, and processor time a frame beside them (timing, which no two runs
// share). An hour of it: lcmslam study --only endurance.

#include <fmt/format.h>
#include <chrono>
#include <cmath>

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

/// CPU of the modern filter's steps where `landmarks` stand along a path and ten are seen at a time, ms.
double step_milliseconds(int landmarks, int steps) {
  using Clock = std::chrono::steady_clock;
  constexpr int seen = 10;
  FastSlamSettings settings;
  settings.rejuvenate = false;
  FastSlam slam(settings);
  Random random(5);
  Clock::time_point begin;
  const int frames = landmarks / seen + steps;
  for (int i = 0; i < frames; ++i) {
    if (i == landmarks / seen) begin = Clock::now();  // all landmarks are there: drive along the last ones
    FeatureFrame frame;
    frame.utime = 1'000'000 + 100'000 * static_cast<Utime>(i);
    frame.width = frame.height = 1;
    frame.fx = frame.fy = 1;
    frame.has_mount = true;
    const int place = std::min(i, landmarks / seen - 1);
    for (int k = 0; k < seen; ++k) {
      Feature feature;
      feature.kind = MeasurementKind::planar;
      feature.landmark_id = seen * place + k;
      feature.depth_sigma = 0.02f;
      feature.point = Eigen::Vector3f(1.0f + 0.3f * static_cast<float>(k), k % 2 == 0 ? 1.0f : -1.0f, 0) +
                      0.02f * Eigen::Vector3f(static_cast<float>(random.normal()),
                                              static_cast<float>(random.normal()), 0);
      frame.features.push_back(feature);
    }
    Motion motion;
    if (i > 0 && i < landmarks / seen) motion.T_from_to = planar_pose(0.2, 0, 0);
    motion.covariance.diagonal() << 1e-5, 1e-5, 1e-8, 1e-8, 1e-8, 1e-5;
    slam.step(motion, frame);
  }
  return 1e3 * std::chrono::duration<double>(Clock::now() - begin).count() / steps;
}

ExperimentResult study_scaling(const StudyContext& context, DriveStore& drives) {
  ExperimentResult result;
  const int seed = context.seeds.front(), laps = context.quick ? 2 : 3;
  result.seeds = {seed};
  const double rate = context.quick ? 1 : 5;
  const auto drive = drives.drive({"kitchen", seed, 0, rate, laps});
  result.settings = {{"scene", "kitchen"}, {"laps", laps}, {"frame_rate_hz", rate}, {"preset", "modern"}};
  MapperChoice choice;
  choice.seed = seed;
  const MappingRun run = map_drive(*drive, choice);
  const std::size_t frames = run.landmark_counts.size();
  Chart chart{"Landmarks of FastSLAM as the way grows", {"frame", ""}, {"landmarks", ""}, {}, false};
  ChartSeries series{"landmarks given out", ChartSeries::Mark::line, {}, {}, {}, {}};
  for (std::size_t i = 0; i < frames; ++i) {
    series.x.push_back(static_cast<double>(i));
    series.y.push_back(run.landmark_counts[i]);
  }
  chart.series = {series};
  ResultTable table{"What a lap adds", {"lap", "landmarks at its end", "added in it"}, {}};
  std::vector<double> added;
  for (int lap = 1; lap <= laps && frames > 0; ++lap) {
    const auto at = [&](int l) {
      return l == 0
                 ? 0
                 : run.landmark_counts[frames * static_cast<std::size_t>(l) / static_cast<std::size_t>(laps) -
                                       1];
    };
    added.push_back(at(lap) - at(lap - 1));
    table.rows.push_back({lap, at(lap), added.back()});
  }
  ResultTable maps{
      "Maps at the end",
      {"what", "value"},
      {{"landmarks", run.landmarks.size()},
       {"points of the dense map", run.cloud.size()},
       {"published by FastSLAM, bytes", run.map_bytes.count("fastslam") ? run.map_bytes.at("fastslam") : 0},
       {"published by ICP, bytes", run.map_bytes.count("icp") ? run.map_bytes.at("icp") : 0},
       {"FastSLAM's pose error, cm", number(100 * path_error(drive->truth, run.fastslam))},
       {"ICP's pose error, cm", number(100 * path_error(drive->truth, run.icp))}}};
  result.charts = {chart};
  result.tables = {table, maps};
  for (const auto& [process, cpu] : run.cpu_seconds)
    result.timing[process + ", CPU s a frame"] =
        cpu / static_cast<double>(std::max<std::size_t>(1, drive->frames.size()));
  for (const int landmarks : {100, 1000, 10000})
    if (!context.quick || landmarks < 10000)
      result.timing[fmt::format("FastSLAM step with {} landmarks, ms", landmarks)] =
          step_milliseconds(landmarks, context.quick ? 50 : 300);
  const double share = added.size() > 1 && added.front() > 0 ? added.back() / added.front() : std::nan("");
  result.finding = fmt::format(
      "The last of {} laps of the same room adds {:.0f} landmarks where the first one added {:.0f} ({:.0f} "
      "%): the map {} "
      "with time alone.",
      laps, added.empty() ? 0 : added.back(), added.empty() ? 0 : added.front(), 100 * share,
      share < 0.2 ? "hardly grows" : "grows");
  return result;
}

}  // namespace

Experiment scaling_experiment(const SharedDrives& drives) {
  return {"scaling", "What grows with the way", "",
          [drives](const StudyContext& context) { return study_scaling(context, *drives); }};
}

}  // namespace lcmslam
