// Thesis, figures 2.1 and 2.2: where 100 particles think that the robot is after one step with a noise of
// 5 cm, and where one landmark, which each of them sets by the same measurement.
//
// With m = R(theta) p + t (2.1-2.3) and Sigma of (t, theta), to first order
//   cov(m) = J Sigma J^T,   J = [I, dR/dtheta p]
// (N - 1) tr(cov(m)^-1 S) of N samples with covariance S is chi-square with 2 (N - 1) degrees of freedom.

#include <fmt/format.h>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tools/study/consistency_study.hpp"
#include "tools/study/report/judgements.hpp"
#include "tools/study/report/mapping_parts.hpp"
#include "tools/study/report/result_parts.hpp"

namespace lcmslam {
namespace {

const Eigen::Vector3d measured(2.0, 0.6, 0.8);  // m, in the robot frame
constexpr double step_length = 0.5;             // m

struct PoseSamples {
  std::vector<Eigen::Vector2d> robots, landmarks;
};

FeatureFrame sight_of(Utime utime, std::uint8_t look, const Eigen::Vector3d& point) {
  FeatureFrame frame;
  frame.utime = utime;
  frame.width = 640;
  frame.height = 480;
  frame.fx = frame.fy = 554;
  frame.cx = 320;
  frame.cy = 240;
  frame.has_mount = true;
  const Eigen::Vector3d p = frame.T_robot_camera.inverse() * point;
  Feature feature;
  feature.kind = MeasurementKind::point;
  feature.x = static_cast<float>(frame.fx * p.x() / p.z() + frame.cx);
  feature.y = static_cast<float>(frame.fy * p.y() / p.z() + frame.cy);
  feature.point = p.cast<float>();
  feature.depth_sigma = 0.01f;
  feature.descriptor.fill(128);
  feature.descriptor[look] = 255;  // a unit vector: what looks otherwise is nearly as far as it can be
  frame.features.push_back(feature);
  return frame;
}

FastSlamSettings sampling_settings(int particles, int seed) {
  FastSlamSettings settings = thesis_preset();
  settings.particles = particles;
  settings.seed = static_cast<std::uint64_t>(seed);
  settings.resample_fraction = 0;  // as sampled, before the filter draws by weight
  return settings;
}

PoseSamples sample_poses(const FastSlamSettings& settings) {
  FastSlam slam(settings);
  slam.step({}, sight_of(1'000'000, 0, {1.5, -0.5, 0.5}));
  Motion motion;
  motion.T_from_to = planar_pose(step_length, 0, 0);
  slam.step(motion, sight_of(1'100'000, 1, measured));
  PoseSamples samples;
  for (const Particle& particle : slam.particles()) {
    samples.robots.emplace_back(particle.T_world_robot.translation().head<2>());
    const CompactLandmark* landmark = particle.map.find(1);  // the second one that was made
    if (landmark == nullptr) throw std::logic_error("a landmark seen for the first time was not made");
    samples.landmarks.emplace_back(landmark->mean.head<2>());
  }
  return samples;
}

Eigen::Vector2d mean_of(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

Eigen::Matrix2d covariance_of(const std::vector<Eigen::Vector2d>& points) {
  const Eigen::Vector2d mean = mean_of(points);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : points) sum += (p - mean) * (p - mean).transpose();
  return sum / static_cast<double>(points.size() - 1);
}

struct PoseTheory {
  std::string name;
  Eigen::Vector2d mean;
  Eigen::Matrix2d covariance;
};

std::vector<PoseTheory> theory_of(const FastSlamSettings& s) {
  const double way = s.translation_noise * s.translation_noise, turn = s.rotation_noise * s.rotation_noise;
  const Eigen::Vector2d p = measured.head<2>(), J(-p.y(), p.x());  // dR/dtheta p at theta = 0
  const Eigen::Matrix2d robot = way * Eigen::Matrix2d::Identity();
  return {{"robot", {step_length, 0}, robot},
          {"landmark", Eigen::Vector2d(step_length, 0) + p, robot + turn * J * J.transpose()}};
}

ExperimentResult study_sampled_poses(const StudyContext& context) {
  constexpr int particles = 100;
  ExperimentResult result;
  result.seeds = context.seeds;
  const std::vector<PoseTheory> theories = theory_of(sampling_settings(particles, 1));
  ResultTable table{"Samples against theory",
                    {"seed", "of", "mean x m", "mean y m", "sigma x cm", "sigma x of theory cm", "sigma y cm",
                     "sigma y of theory cm", "chi square", "95 % from", "to", "inside"},
                    {}};
  int inside = 0, all = 0;
  std::vector<double> ratios;
  std::map<std::string, double> together;  // chi square over the seeds
  const double freedom = 2.0 * (particles - 1);
  const double low = chi_square_quantile(freedom, -1.96), high = chi_square_quantile(freedom, 1.96);
  for (const int seed : context.seeds) {
    const PoseSamples samples = sample_poses(sampling_settings(particles, seed));
    for (const PoseTheory& theory : theories) {
      const auto& points = theory.name == "robot" ? samples.robots : samples.landmarks;
      const Eigen::Vector2d mean = mean_of(points);
      const Eigen::Matrix2d S = covariance_of(points), P = theory.covariance;
      const double statistic = (particles - 1) * (P.inverse() * S).trace();
      const bool fits = statistic > low && statistic < high;
      together[theory.name] += statistic;
      inside += fits ? 1 : 0;
      ++all;
      ratios.push_back(std::sqrt(S.determinant() / P.determinant()));
      table.rows.push_back({seed, theory.name, number(mean.x()), number(mean.y()),
                            number(100 * std::sqrt(S(0, 0))), number(100 * std::sqrt(P(0, 0))),
                            number(100 * std::sqrt(S(1, 1))), number(100 * std::sqrt(P(1, 1))),
                            number(statistic), number(low), number(high), fits ? "yes" : "no"});
      if (seed != context.seeds.front()) continue;
      Chart chart;
      chart.title = theory.name == "robot" ? "Poses of the robot in 100 particles (figure 2.1)"
                                           : "One landmark in 100 particles (figure 2.2)";
      chart.x = {"x", "m"};
      chart.y = {"y", "m"};
      chart.equal_scales = true;
      chart.series = {points_series("samples", points), ellipse_series("samples' covariance, 95 %", mean, S),
                      ellipse_series("theory, 95 %", theory.mean, P)};
      result.charts.push_back(chart);
    }
  }
  result.tables = {table};
  result.settings = {{"particles", particles},
                     {"translation_noise_m", thesis_preset().translation_noise},
                     {"rotation_noise_rad", thesis_preset().rotation_noise},
                     {"landmark_in_robot_frame_m", {measured.x(), measured.y(), measured.z()}}};
  // One case in twenty falls outside where all is as theory says: the seeds' sums are judged.
  const bool agrees = std::all_of(together.begin(), together.end(), [&](const auto& sum) {
    return follows_chi_square(sum.second, freedom * static_cast<double>(context.seeds.size()));
  });
  result.agreement = agrees ? Agreement::agrees : Agreement::differs;
  result.finding = fmt::format(
      "The sampled covariance of robot and landmark lies within the 95 % band of theory in {} of {} cases; "
      "its area over theory's is {}: over all seeds sampling and landmarks {} equations 2.1 to 2.3.",
      inside, all, in_words(ratios, 1, "", 2), agrees ? "follow" : "do not follow");
  return result;
}

}  // namespace

Experiment sampled_poses_experiment() {
  return {"sampled-poses", "Poses and a landmark in 100 particles", "figures 2.1 and 2.2",
          study_sampled_poses};
}

}  // namespace lcmslam
