#include "fastslam/frame_association.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "fastslam/consensus.hpp"
#include "fastslam/pose_space.hpp"

namespace lcmslam {
namespace {

constexpr double kLargeTranslation = 0.1, kLargeRotation = 0.05;  // m, rad
constexpr std::uint64_t kStream = 0x6173736f63;  // random stream of association, apart from particles'

std::vector<ObservedLandmark> pair_up(const std::vector<LandmarkMatch>& matches,
                                      const std::vector<FeaturePoint>& points, const ParticleMap& map) {
  std::vector<ObservedLandmark> pairs;
  pairs.reserve(matches.size());
  for (const LandmarkMatch& m : matches)
    pairs.push_back(
        {points[static_cast<std::size_t>(m.point)].measurement, *map.find(static_cast<std::size_t>(m.slot))});
  return pairs;
}

void keep_inliers(const std::vector<char>& inlier, FrameAssociation& result) {
  std::vector<LandmarkMatch> kept;
  for (std::size_t i = 0; i < result.matches.size(); ++i)
    (inlier[i] ? kept : result.rejected).push_back(result.matches[i]);
  result.matches = std::move(kept);
}

// Squared Mahalanobis distance of the consensus pose from the prior, in the free components.
template <int D>
double distance2(const Vector6d& correction, const Matrix6d& covariance) {
  const typename PoseSpace<D>::Vector v = PoseSpace<D>::reduce(correction);
  return v.dot(PoseSpace<D>::reduce(covariance).llt().solve(v));
}

// Matches that the prior alone explains: d^2 under S + J Q J^T passes the gate.
template <int D>
std::vector<char> explained_by_prior(const std::vector<ObservedLandmark>& pairs, const Eigen::Isometry3d& T,
                                     const Matrix6d& Q, double gate2) {
  std::vector<char> explained(pairs.size(), 0);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Innovation innovation = innovate(pairs[i].landmark, pairs[i].measurement, T);
    const auto J = residual_jacobian<D>(pairs[i].measurement.kind, innovation.predicted);
    const Eigen::Matrix3d S =
        innovation.landmark + pairs[i].measurement.covariance + J * PoseSpace<D>::reduce(Q) * J.transpose();
    explained[i] = innovation.residual.dot(S.inverse() * innovation.residual) <= gate2;
  }
  return explained;
}

// After a slip the motion is the one that the observations agree on, known as well as they say plus a
// part of the correction itself, since other particles' maps differ from the best one's.
void correct_motion(const Vector6d& correction, const Matrix6d& covariance, Motion& prior) {
  prior.T_from_to = prior.T_from_to * se3_exp(correction);
  prior.covariance += covariance;
  for (int i = 0; i < 6; ++i) {
    const double sigma = std::min(0.3 * std::abs(correction(i)), i < 3 ? 0.1 : 0.05);
    prior.covariance(i, i) += sigma * sigma;
  }
}

}  // namespace

FrameAssociator::FrameAssociator(const FastSlamSettings& settings)
    : settings_(settings), random_(settings.seed, kStream) {}

FrameAssociation FrameAssociator::associate(const FeatureFrame& frame,
                                            const std::vector<FeaturePoint>& points,
                                            const Eigen::Isometry3d& T_world_robot, const Motion& prior,
                                            const ParticleMap& map, const LandmarkIndex& index) {
  const FastSlamSettings& s = settings_;
  FrameAssociation result;
  result.prior = prior;
  const Eigen::Isometry3d T_predicted = T_world_robot * prior.T_from_to;
  result.visible = visible_landmarks(map, index, T_predicted, frame, s);
  result.matches = match_visible(frame, points, result.visible, index, s.search_radius * frame.width, s);
  result.known = match_known(points, map, index, T_predicted);
  const auto by_descriptor = std::count_if(points.begin(), points.end(),
                                           [](const FeaturePoint& point) { return point.landmark_id < 0; });
  if (!result.known.empty()) steps_without_agreement_ = 0;
  if (!s.verify_by_consensus || (by_descriptor == 0 && !points.empty())) return result;

  auto pairs = pair_up(result.matches, points, map);
  auto consensus = find_consensus(pairs, T_predicted, s.planar, s.minimum_consensus, random_);
  if (!consensus && !result.visible.empty()) {  // a large slip: look over the whole image
    auto wide = match_visible(frame, points, result.visible, index, 2.0 * frame.width, s);
    auto wide_pairs = pair_up(wide, points, map);
    consensus = find_consensus(wide_pairs, T_predicted, s.planar, s.minimum_consensus, random_);
    if (consensus) result.matches = std::move(wide);
  }

  if (consensus) {
    steps_without_agreement_ = 0;
    result.agreed = true;
    keep_inliers(consensus->inlier, result);
    const Vector6d correction = se3_log(T_predicted.inverse() * consensus->T_world_robot);
    const Matrix6d expected = prior.covariance + consensus->covariance;
    const double d2 = s.planar ? distance2<3>(correction, expected) : distance2<6>(correction, expected);
    result.slipped = s.detect_slips && d2 > s.slip_gate;
    // A large correction, even an expected one, is also where the proposal should be linearised.
    const bool large =
        correction.head<3>().norm() > kLargeTranslation || correction.tail<3>().norm() > kLargeRotation;
    result.corrected = result.slipped || large;
    if (result.corrected) correct_motion(correction, consensus->covariance, result.prior);
    return result;
  }

  const double gate2 = -2 * std::log(s.gate);
  keep_inliers(s.planar ? explained_by_prior<3>(pairs, T_predicted, prior.covariance, gate2)
                        : explained_by_prior<6>(pairs, T_predicted, prior.covariance, gate2),
               result);
  const bool enough = by_descriptor >= s.minimum_consensus;
  if (enough && result.known.empty()) ++steps_without_agreement_;
  const auto established = std::count_if(result.visible.begin(), result.visible.end(), [&](const auto& v) {
    return index.record(v.slot).observations >= s.minimum_observations;
  });
  result.contradicted = enough && result.known.empty() && established >= 2 * s.minimum_consensus;
  if (steps_without_agreement_ > s.relocalise_after) find_back(frame, points, map, index, result);
  return result;
}

void FrameAssociator::find_back(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                const ParticleMap& map, const LandmarkIndex& index,
                                FrameAssociation& result) {
  auto matches = match_all(frame, points, map, index, settings_, random_);
  const auto consensus = find_consensus(pair_up(matches, points, map), Eigen::Isometry3d::Identity(),
                                        settings_.planar, settings_.minimum_consensus, random_);
  // Against a whole map chance agreements exist: most of what matched must agree.
  if (!consensus || 2 * consensus->inliers < static_cast<int>(matches.size())) return;
  result.matches = std::move(matches);
  result.rejected.clear();
  keep_inliers(consensus->inlier, result);
  result.corrected = true;
  result.T_world_found = consensus->T_world_robot;
  result.prior.covariance = 4 * consensus->covariance;
  result.prior.covariance.diagonal().head<3>().array() += 0.05 * 0.05;
  result.prior.covariance.diagonal().tail<3>().array() += 0.02 * 0.02;
  result.agreed = true;
  result.contradicted = false;
  steps_without_agreement_ = 0;
}

}  // namespace lcmslam
