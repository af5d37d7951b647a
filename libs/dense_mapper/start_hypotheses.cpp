#include <lcmslam/dense_mapper/start_hypotheses.hpp>

#include <Eigen/Dense>

#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {
namespace {

bool alike(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Isometry3d step = a.inverse() * b;
  return step.translation().norm() < 0.05 && rotation_angle(step) < 0.05;
}

/// What SURF saw is knowledge; a bare start is none.
const Prior* knowledge(const Hypothesis& hypothesis) {
  return hypothesis.prior.information.isZero() ? nullptr : &hypothesis.prior;
}

double share_on_surface(const Cloud& source, const Target& target, const Eigen::Isometry3d& T,
                        const HypothesisSettings& settings) {
  RegistrationSettings judge = settings.fine;
  judge.max_distance = settings.judged_distance;
  const RegistrationResult seen = look(source, target, T, judge);
  return seen.pairs > 0 ? seen.overlap * seen.inliers / seen.pairs : 0;
}

}  // namespace

HypothesisSettings::HypothesisSettings() {
  coarse.selection = fine.selection = SelectionKind::uniform;
  coarse.selected_points = 400;
  coarse.max_distance = 0.25;
  coarse.min_distance = 0.12;
  coarse.max_normal_angle = 0.8;
  coarse.max_iterations = 15;
  coarse.epsilon_translation = 4e-3;
  coarse.epsilon_rotation = 2e-3;
  fine.metric = MetricKind::plane_to_plane;
  fine.selected_points = 3000;
  fine.max_distance = 0.10;
  fine.max_iterations = 20;
}

std::vector<Hypothesis> surf_hypotheses(const FeatureFrame& source, const FeatureFrame& target,
                                        const HypothesisSettings& settings) {
  std::vector<Hypothesis> hypotheses;
  for (const double ratio : settings.ratios) {
    MatchingSettings matching;
    matching.ratio = ratio;
    RigidRansacSettings ransac;
    ransac.min_inliers = settings.min_inliers;
    Random random(1);
    const auto found =
        align_ransac(target, source, match(target.features, source.features, matching), ransac, random);
    if (!found.success) continue;
    if (!hypotheses.empty() && alike(hypotheses.front().prior.T_target_source, found.T_a_b)) continue;
    Matrix6d covariance = found.covariance;
    covariance.diagonal().head<3>().array() += settings.floor_translation * settings.floor_translation;
    covariance.diagonal().tail<3>().array() += settings.floor_rotation * settings.floor_rotation;
    hypotheses.push_back({{found.T_a_b, covariance.inverse()}, "SURF"});
  }
  return hypotheses;
}

HypothesisResult register_hypotheses(const Cloud& source, const Target& target,
                                     const std::vector<Hypothesis>& hypotheses,
                                     const HypothesisSettings& settings) {
  HypothesisResult best;
  for (const Hypothesis& hypothesis : hypotheses) {
    const Prior* prior = knowledge(hypothesis);
    const auto coarse =
        register_cloud(source, target, hypothesis.prior.T_target_source, settings.coarse, prior);
    const auto fine = register_cloud(source, target, coarse.T_target_source, settings.fine, prior);
    if (!fine.ok()) continue;
    const double score = share_on_surface(source, target, fine.T_target_source, settings);
    if (score <= best.score) continue;
    best = {fine, hypothesis.origin, score};
  }
  return best;
}

}  // namespace lcmslam
