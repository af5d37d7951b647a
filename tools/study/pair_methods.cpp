#include <fmt/format.h>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/dense_mapper/start_hypotheses.hpp>
#include <lcmslam/dense_mapper/thesis/alternating.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/rgbd/colour_overlap.hpp>
#include "tools/study/pair_study.hpp"

namespace lcmslam {
namespace {

using Transform = std::optional<Eigen::Isometry3d>;

/// Thesis algorithm 3.1: point to point, exact neighbours, nothing rejected.
RegistrationSettings plain_icp() {
  RegistrationSettings settings = AlternatingSettings().registration;
  settings.max_iterations = 100;
  settings.epsilon_rms = 1e-5;
  settings.epsilon_translation = settings.epsilon_rotation = 0;
  return settings;
}

Transform icp_from(const Eigen::Isometry3d& T_start, const PairView& source, const PairView& target) {
  const RegistrationResult result =
      register_cloud(source.cloud, KdTreeTarget(target.cloud), T_start, plain_icp());
  return result.ok() ? Transform(result.T_target_source) : std::nullopt;
}

RigidRansacResult ransac(const PairView& source, const PairView& target, const std::vector<Match>& matches) {
  Random random(1);
  return align_ransac(target.features, source.features, matches, {}, random);
}

Transform surf_alone(const PairView& source, const PairView& target) {
  const auto result = ransac(source, target, match(target.features.features, source.features.features));
  return result.success ? Transform(result.T_a_b) : std::nullopt;
}

/// Algorithm 3.2 with so many iterations on the clouds in turn with so many on the SURF points.
PairMethod thesis(int on_cloud, int on_features, FeaturePairing pairing, bool checked) {
  const char* kind = pairing == FeaturePairing::fixed ? "fixed" : "nearest";
  PairMethod method;
  method.name = fmt::format("3.2 {} {}:{}{}", kind, on_cloud, on_features, checked ? "" : ", all matches");
  method.solve = [=](const PairView& source, const PairView& target) -> Transform {
    AlternatingSettings settings;
    settings.cloud_iterations = on_cloud;
    settings.feature_iterations = on_features;
    settings.pairing = pairing;
    const ImageOverlap overlap = colour_overlap(source.colour, target.colour);
    const Cloud sub = overlapping_points(source.cloud, overlap, source.camera);
    const FeaturePairs features = feature_pairs(source.features, target.features, checked);
    const Eigen::Isometry3d T_start =
        align_start(features, settings.registration).value_or(Eigen::Isometry3d::Identity());
    const auto result = register_alternating(sub, KdTreeTarget(target.cloud), features, T_start, settings);
    return result.ok() ? Transform(result.T_target_source) : std::nullopt;
  };
  return method;
}

/// SURF with RANSAC, then point to plane, coarse and fine, which is free to leave the start.
Transform one_start(const PairView& source, const PairView& target) {
  const Transform start = surf_alone(source, target);
  const KdTreeTarget tree(target.cloud);
  const auto coarse = register_cloud(source.cloud, tree, start.value_or(Eigen::Isometry3d::Identity()),
                                     DenseMapperSettings::coarse_defaults());
  const auto fine =
      register_cloud(source.cloud, tree, coarse.T_target_source, DenseMapperSettings::fine_defaults());
  return fine.ok() ? Transform(fine.T_target_source) : std::nullopt;
}

/// The modern start: several hypotheses, each with its SURF pairs as knowledge, judged by the clouds.
Transform modern_start(const PairView& source, const PairView& target) {
  std::vector<Hypothesis> starts = surf_hypotheses(source.features, target.features);
  if (starts.empty()) starts.push_back({Prior(), "identity"});
  const auto best = register_hypotheses(source.cloud, KdTreeTarget(target.cloud), starts);
  return best.registration.ok() ? Transform(best.registration.T_target_source) : std::nullopt;
}

}  // namespace

std::vector<PairMethod> pair_methods() {
  std::vector<PairMethod> methods;
  methods.push_back({"plain ICP (3.1)", [](const PairView& source, const PairView& target) {
                       return icp_from(Eigen::Isometry3d::Identity(), source, target);
                     }});
  methods.push_back({"SURF alone", surf_alone});
  methods.push_back({"SURF, then plain ICP", [](const PairView& source, const PairView& target) -> Transform {
                       const Transform start = surf_alone(source, target);
                       return start ? icp_from(*start, source, target) : std::nullopt;
                     }});
  for (const auto pairing : {FeaturePairing::nearest, FeaturePairing::fixed})
    for (const auto& [on_cloud, on_features] : {std::pair(1, 1), std::pair(1, 5), std::pair(5, 1)})
      methods.push_back(thesis(on_cloud, on_features, pairing, true));
  methods.push_back(thesis(1, 1, FeaturePairing::nearest, false));
  methods.push_back({"one start, then point to plane", one_start});
  methods.push_back({"modern start", modern_start});
  return methods;
}

}  // namespace lcmslam
