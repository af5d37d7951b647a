// Section 2.1.1: FastSLAM 1.0 draws particles from the odometry alone. Where measurements are much better
// than that, few particles land where the measurement says, and the filter diverges (Montemerlo 2003); 2.0
// draws them from both. Measured in a plane of beacons of known identity, all else being the thesis's preset,
// with noise that is as the filter is told.

#include <fmt/format.h>
#include <cmath>

#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/mapping_run.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

constexpr double step_sigma = 0.02, turn_sigma = 0.01;  // m, rad: of one step of the odometry
constexpr double sight = 6;                             // m

/// Laps on an ellipse among beacons.
Eigen::Isometry3d lap_pose(int frame) {
  const double t = 0.05 * frame;
  return planar_pose(4 * std::cos(t), 3 * std::sin(t), std::atan2(3 * std::cos(t), -4 * std::sin(t)));
}

struct FilterErrors {
  double filter = 0, odometry = 0;  ///< ATE RMSE, m
  double wrong = 0;                 ///< share of the steps that are beyond their own 99 % bound
};

FilterErrors drive_among_beacons(ProposalKind proposal, double measurement_sigma, int particles, int frames,
                                 int seed) {
  constexpr int beacons = 20;
  constexpr double outside = 11.34;  // chi square of three degrees of freedom, 99 %
  Random random(static_cast<std::uint64_t>(seed), 21);
  std::vector<Eigen::Vector3d> places;
  places.reserve(beacons);
  for (int i = 0; i < beacons; ++i) places.emplace_back(random.uniform(-7, 7), random.uniform(-6, 6), 0);
  FastSlamSettings settings = thesis_preset();
  settings.proposal = proposal;
  settings.particles = particles;
  settings.seed = static_cast<std::uint64_t>(seed);
  settings.use_motion_covariance = true;
  settings.translation_noise = settings.rotation_noise = 1e-4;
  settings.measurement_sigma = 0;  // what each measurement says
  FastSlam slam(settings);
  Trajectory truth, filter, wheels;
  Eigen::Isometry3d T_odometry = Eigen::Isometry3d::Identity();
  int wrong = 0;
  for (int i = 0; i < frames; ++i) {
    const Eigen::Isometry3d T = lap_pose(0).inverse() * lap_pose(i);
    Motion motion;
    if (i > 0) {
      Vector6d twist = se3_log(lap_pose(i - 1).inverse() * lap_pose(i));
      twist += (Vector6d() << step_sigma * random.normal(), step_sigma * random.normal(), 0, 0, 0,
                turn_sigma * random.normal())
                   .finished();
      motion.T_from_to = se3_exp(twist);
      motion.covariance.diagonal() << step_sigma * step_sigma, step_sigma * step_sigma, 1e-8, 1e-8, 1e-8,
          turn_sigma * turn_sigma;
      T_odometry = T_odometry * motion.T_from_to;
    }
    FeatureFrame frame;
    frame.utime = 1'000'000 + 100'000 * static_cast<Utime>(i);
    frame.width = frame.height = 1;
    frame.fx = frame.fy = 1;
    frame.has_mount = true;
    for (int b = 0; b < beacons; ++b) {
      const Eigen::Vector3d p = lap_pose(i).inverse() * places[static_cast<std::size_t>(b)];
      const double dx = measurement_sigma * random.normal(), dy = measurement_sigma * random.normal();
      if (p.norm() > sight || p.x() < 0.3) continue;
      Feature feature;
      feature.kind = MeasurementKind::planar;
      feature.landmark_id = b;
      feature.depth_sigma = static_cast<float>(measurement_sigma);
      feature.point = Eigen::Vector3d(p.x() + dx, p.y() + dy, 0).cast<float>();
      frame.features.push_back(feature);
    }
    const StepResult step = slam.step(motion, frame);
    truth.push_back({frame.utime, T});
    filter.push_back({frame.utime, step.T_world_robot});
    wheels.push_back({frame.utime, T_odometry});
    const Vector6d e = se3_log(step.T_world_robot.inverse() * T);
    const std::vector<int> plane = {0, 1, 5};
    const Eigen::Matrix3d P = step.covariance(plane, plane) + 1e-12 * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d seen = e(plane);
    wrong += i > 0 && seen.dot(P.inverse() * seen) > outside ? 1 : 0;
  }
  return {path_error(truth, filter), path_error(truth, wheels), static_cast<double>(wrong) / (frames - 1)};
}

ExperimentResult study_filter_divergence(const StudyContext& context) {
  ExperimentResult result;
  result.seeds = context.seeds;
  const std::vector<double> sigmas = context.quick
                                         ? std::vector<double>{0.002, 0.01, 0.05}
                                         : std::vector<double>{0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1};
  const std::vector<int> counts =
      context.quick ? std::vector<int>{10, 100} : std::vector<int>{10, 30, 100, 300, 1000};
  const int frames = context.quick ? 130 : 380;  // a lap is 126
  result.settings = {{"frames", frames},
                     {"odometry_sigma_m_per_step", step_sigma},
                     {"odometry_sigma_rad_per_step", turn_sigma},
                     {"beacons", 20}};
  struct Cell {
    std::vector<double> error, odometry, wrong;
  };
  const ProposalKind kinds[] = {ProposalKind::motion, ProposalKind::measurement};
  const char* const names[] = {"FastSLAM 1.0", "FastSLAM 2.0"};
  const std::size_t columns = sigmas.size(), rows = counts.size(), seeds = context.seeds.size();
  std::vector<FilterErrors> errors(2 * rows * columns * seeds);
  run_side_by_side(errors.size(), [&](std::size_t i) {
    const std::size_t seed = i % seeds, column = i / seeds % columns, row = i / seeds / columns % rows;
    errors[i] = drive_among_beacons(kinds[i / seeds / columns / rows], sigmas[column], counts[row], frames,
                                    context.seeds[seed]);
  });
  ResultTable table{"FastSLAM 1.0 and 2.0",
                    {"filter", "particles", "measurement sigma cm", "path error cm", "least", "most",
                     "odometry's error cm", "runs worse than odometry", "steps beyond their 99 % bound, %"},
                    {}};
  std::vector<HeatMap> maps;
  std::vector<std::vector<std::vector<double>>> medians(2);
  int diverged[2] = {0, 0};
  for (std::size_t kind = 0; kind < 2; ++kind) {
    HeatMap map{std::string(names[kind]) + ": path error",
                {"measurement sigma", "m", true},
                {"particles", "", true},
                {"path error", "cm", true},
                sigmas,
                std::vector<double>(counts.begin(), counts.end()),
                {}};
    HeatMap bold = map;
    bold.title = std::string(names[kind]) + ": steps that err beyond their own 99 % bound";
    bold.value = {"share of the steps", "%", false};
    for (std::size_t row = 0; row < rows; ++row) {
      std::vector<double> line, share;
      medians[kind].emplace_back();
      for (std::size_t column = 0; column < columns; ++column) {
        Cell cell;
        int worse = 0;
        for (std::size_t seed = 0; seed < seeds; ++seed) {
          const FilterErrors& e = errors[((kind * rows + row) * columns + column) * seeds + seed];
          cell.error.push_back(e.filter);
          cell.odometry.push_back(e.odometry);
          cell.wrong.push_back(e.wrong);
          worse += e.filter > e.odometry ? 1 : 0;
        }
        diverged[kind] += worse;
        const Spread spread = spread_of(cell.error);
        medians[kind][row].push_back(spread.median);
        line.push_back(100 * spread.median);
        share.push_back(100 * spread_of(cell.wrong).median);
        table.rows.push_back({names[kind], counts[row], number(100 * sigmas[column]),
                              number(100 * spread.median), number(100 * spread.low),
                              number(100 * spread.high), number(100 * spread_of(cell.odometry).median), worse,
                              number(share.back())});
      }
      map.values.push_back(line);
      bold.values.push_back(share);
    }
    maps.push_back(map);
    maps.push_back(bold);
  }
  result.heat_maps = maps;
  result.tables = {table};
  // At the thesis's hundred particles.
  const std::size_t hundred =
      static_cast<std::size_t>(std::find(counts.begin(), counts.end(), 100) - counts.begin());
  Chart chart{"Path error with 100 particles",
              {"measurement sigma", "m", true},
              {"path error", "cm", true},
              {},
              false};
  for (std::size_t kind = 0; kind < 2; ++kind) {
    std::vector<std::vector<double>> values;
    for (std::size_t column = 0; column < columns; ++column) {
      values.emplace_back();
      for (std::size_t seed = 0; seed < seeds; ++seed)
        values.back().push_back(errors[((kind * rows + hundred) * columns + column) * seeds + seed].filter);
    }
    chart.series.push_back(spread_series(names[kind], sigmas, values, 100));
  }
  result.charts = {chart};
  const double factor = medians[0][hundred][0] / medians[1][hundred][0];
  const double noisy_factor = medians[0][hundred].back() / medians[1][hundred].back();
  const bool as_claimed = factor > 3 && factor > 2 * noisy_factor;
  result.agreement = as_claimed     ? Agreement::agrees
                     : factor > 1.5 ? Agreement::agrees_in_part
                                    : Agreement::differs;
  result.finding = fmt::format(
      "With 100 particles FastSLAM 1.0 errs {:.1f} times as much as 2.0 where measurements are good to "
      "{:.1f} cm, "
      "and {:.1f} times where they are to {:.0f} cm; it is worse than its odometry in {} of {} runs, 2.0 in "
      "{}: "
      "that 1.0 fails where measurement noise is low {}.",
      factor, 100 * sigmas.front(), noisy_factor, 100 * sigmas.back(), diverged[0], errors.size() / 2,
      diverged[1], as_claimed ? "holds" : "holds in part at most");
  return result;
}

}  // namespace

Experiment filter_divergence_experiment() {
  return {"filter-divergence", "FastSLAM 1.0 and 2.0 over noise and particles", "section 2.1.1",
          study_filter_divergence};
}

}  // namespace lcmslam
