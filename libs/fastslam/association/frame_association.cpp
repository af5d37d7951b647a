#include <lcmslam/fastslam/association/frame_association.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include <lcmslam/fastslam/association/consensus.hpp>
#include <lcmslam/fastslam/association/expected_landmarks.hpp>
#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

// Of a place dozens of features must agree, so that a few lost neighbours do not matter.
constexpr SearchSettings place_search{0.03, 500};
constexpr double large_translation = 0.1, large_rotation = 0.05;  // m, rad
// Random streams of association, apart from particles'.
constexpr std::uint64_t association_stream = 0x6173736f63, ground_stream = 0x67726f756e64;

std::vector<ObservedLandmark> pair_up(const std::vector<LandmarkMatch>& matches,
                                      const std::vector<FeaturePoint>& points, const ParticleMap& map) {
  std::vector<ObservedLandmark> pairs;
  pairs.reserve(matches.size());
  for (const LandmarkMatch& m : matches)
    pairs.push_back(
        {points[static_cast<std::size_t>(m.point)].measurement, *map.find(static_cast<std::size_t>(m.slot))});
  return pairs;
}

void keep(const std::vector<char>& believed, FrameAssociation& result) {
  std::vector<LandmarkMatch> kept;
  for (std::size_t i = 0; i < result.matches.size(); ++i)
    (believed[i] ? kept : result.rejected).push_back(result.matches[i]);
  result.matches = std::move(kept);
}

// Squared Mahalanobis distance of the consensus pose from the prior, in the free components.
template <int D>
double distance2(const Vector6d& correction, const Matrix6d& covariance) {
  const typename PoseSpace<D>::Vector v = PoseSpace<D>::reduce(correction);
  return v.dot(PoseSpace<D>::reduce(covariance).llt().solve(v));
}

// Matches that a pose explains: d^2 under S + J Q J^T passes the gate.
template <int D>
std::vector<char> explained(const std::vector<ObservedLandmark>& pairs, const Eigen::Isometry3d& T,
                            const Matrix6d& Q, double gate2) {
  std::vector<char> believed(pairs.size(), 0);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Innovation innovation = innovate(pairs[i].landmark, pairs[i].measurement, T);
    const auto J = residual_jacobian<D>(pairs[i].measurement, innovation.predicted);
    const Eigen::Matrix3d S =
        innovation.landmark + pairs[i].measurement.covariance + J * PoseSpace<D>::reduce(Q) * J.transpose();
    believed[i] = innovation.residual.dot(S.inverse() * innovation.residual) <= gate2;
  }
  return believed;
}

std::vector<char> explained(const std::vector<ObservedLandmark>& pairs, const Eigen::Isometry3d& T,
                            const Matrix6d& Q, const FastSlamSettings& s) {
  const double gate2 = -2 * std::log(s.gate);
  return s.planar ? explained<3>(pairs, T, Q, gate2) : explained<6>(pairs, T, Q, gate2);
}

// The consensus judges points, its pose the bearings.
void keep_agreeing(const Consensus& consensus, const std::vector<FeaturePoint>& points,
                   const ParticleMap& map, const FastSlamSettings& s, FrameAssociation& result) {
  const auto pairs = pair_up(result.matches, points, map);
  std::vector<char> believed = explained(pairs, consensus.T_world_robot, consensus.covariance, s);
  std::size_t next = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (!points[static_cast<std::size_t>(result.matches[i].point)].is_bearing())
      believed[i] = consensus.inlier[next++];
  keep(believed, result);
}

// Wider searches find more by chance.
bool clearly_more(int a, int b) {
  return 2 * a > 3 * b;
}

// How far off a slip may put the prediction: a gate of three sigma covers settings.search_radius.
Matrix6d slip_covariance(const FeatureFrame& frame, const FastSlamSettings& s) {
  const double rotation = s.search_radius * frame.width / (3 * frame.fx);
  constexpr double translation = 0.05;  // m
  Matrix6d Q = Matrix6d::Zero();
  Q.diagonal().head<3>().setConstant(translation * translation);
  Q.diagonal().tail<3>().setConstant(rotation * rotation);
  return Q;
}

// The prior as the search sees it: in the plane only (x, y, heading) are free.
Matrix6d free_part(const Matrix6d& covariance, bool planar) {
  return planar ? PoseSpace<3>::expand(PoseSpace<3>::reduce(covariance)) : covariance;
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
    : settings_(settings),
      random_(settings.seed, association_stream),
      ground_random_(settings.seed, ground_stream),
      matcher_(settings.guided ? place_search : SearchSettings{1, 1}) {}  // 1: every descriptor

FrameAssociation FrameAssociator::associate(const FeatureFrame& frame,
                                            const std::vector<FeaturePoint>& points,
                                            const Eigen::Isometry3d& T_world_robot, const Motion& prior,
                                            const ParticleMap& map, const LandmarkIndex& index,
                                            Whereabouts whereabouts) {
  const FastSlamSettings& s = settings_;
  FrameAssociation result;
  result.prior = prior;
  const Eigen::Isometry3d T_predicted = T_world_robot * prior.T_from_to;
  grid_.follow(map, index);
  result.visible = visible_landmarks(grid_, index, T_predicted, frame, s);
  result.known = match_known(points, map, index, T_predicted);
  matcher_.begin(frame, points);
  const auto by_descriptor = std::count_if(points.begin(), points.end(), [](const FeaturePoint& point) {
    return point.landmark_id < 0 && !point.is_bearing();
  });
  if (!result.known.empty()) steps_without_agreement_ = 0;
  const Matrix6d Q = free_part(prior.covariance, s.planar);
  if (!s.verify_by_consensus) {
    result.matches =
        s.guided ? matcher_.guided(result.visible, map, index, T_predicted, Q + slip_covariance(frame, s), s)
                 : matcher_.everywhere(map, index, s);
    return result;
  }
  if (std::all_of(points.begin(), points.end(), [](const auto& p) { return p.landmark_id >= 0; }) &&
      !points.empty())
    return result;

  Attempt found;
  if (whereabouts != Whereabouts::anywhere)
    found = search(points, result.visible, frame, T_predicted, Q, map, index);
  if (whereabouts != Whereabouts::predicted && !found.consensus) {
    recognised_ = 0;
    steps_without_agreement_ += by_descriptor >= s.minimum_consensus && result.known.empty() ? 1 : 0;
    if (find_back(points, map, index, s.minimum_consensus, result)) steps_without_agreement_ = 0;
    return result;
  }
  if (found.consensus && found.inliers() < 0.9 * usual_inliers_ &&
      slips(*found.consensus, T_predicted, prior.covariance)) {
    // What is near, and tells most, lay outside the gates: once more from where the robot is.
    const Eigen::Isometry3d& T_seen = found.consensus->T_world_robot;
    Attempt again = agree(matcher_.guided(result.visible, map, index, T_seen, Q, s), points, map, T_seen);
    if (again.inliers() > found.inliers()) found = std::move(again);
  }
  result.free = s.planar ? agree_in_space(found, points, map, T_predicted) : found.consensus;
  result.matches = std::move(found.matches);
  const std::optional<Consensus>& consensus = found.consensus;
  if (!consensus) recognised_ = 0;
  if (consensus && close_loop(frame, points, map, index, T_predicted, result)) return result;
  if (consensus) {
    steps_without_agreement_ = 0;
    result.agreed = true;
    keep_agreeing(*consensus, points, map, s, result);
    const Vector6d correction = se3_log(T_predicted.inverse() * consensus->T_world_robot);
    result.slipped = slips(*consensus, T_predicted, prior.covariance);
    // A large correction, even an expected one, is also where the proposal should be linearised.
    const bool large =
        correction.head<3>().norm() > large_translation || correction.tail<3>().norm() > large_rotation;
    result.corrected = result.slipped || large;
    if (result.corrected) correct_motion(correction, consensus->covariance, result.prior);
    return result;
  }

  keep(explained(pair_up(result.matches, points, map), T_predicted, prior.covariance, s), result);
  // Where few features have depth those without it tell whether the prediction is right, if they are twice as
  // many: a pixel says less than a point.
  result.confirmed = found.supported && static_cast<int>(result.matches.size()) >= 2 * s.minimum_consensus;
  if (result.confirmed) {
    steps_without_agreement_ = 0;
    return result;
  }
  const bool enough = by_descriptor >= s.minimum_consensus;
  if (enough && result.known.empty()) ++steps_without_agreement_;
  const ExpectedLandmarks expected = expected_landmarks(result.visible, frame, points, T_predicted, index, s);
  result.contradicted = enough && result.known.empty() && expected.should_be_seen(s.minimum_consensus);
  result.hidden = result.contradicted && expected.are_hidden();
  if (steps_without_agreement_ > s.relocalise_after) {
    matcher_.begin(frame, points);
    if (find_back(points, map, index, s.minimum_consensus, result)) steps_without_agreement_ = 0;
  }
  return result;
}

// The observations agree on a motion that the odometry excludes.
bool FrameAssociator::slips(const Consensus& consensus, const Eigen::Isometry3d& T_predicted,
                            const Matrix6d& covariance) const {
  const Vector6d correction = se3_log(T_predicted.inverse() * consensus.T_world_robot);
  const Matrix6d expected = covariance + consensus.covariance;
  const double d2 =
      settings_.planar ? distance2<3>(correction, expected) : distance2<6>(correction, expected);
  return settings_.detect_slips && d2 > settings_.slip_gate;
}

FrameAssociator::Attempt FrameAssociator::agree(std::vector<LandmarkMatch> matches,
                                                const std::vector<FeaturePoint>& points,
                                                const ParticleMap& map,
                                                const Eigen::Isometry3d& T_predicted) {
  std::vector<LandmarkMatch> of_points;
  for (const LandmarkMatch& m : matches)
    if (!points[static_cast<std::size_t>(m.point)].is_bearing()) of_points.push_back(m);
  Attempt attempt;
  attempt.consensus = find_consensus(pair_up(of_points, points, map), T_predicted, settings_.planar,
                                     settings_.minimum_consensus, random_);
  attempt.matches = std::move(matches);
  return attempt;
}

std::optional<Consensus> FrameAssociator::agree_in_space(const Attempt& attempt,
                                                         const std::vector<FeaturePoint>& points,
                                                         const ParticleMap& map,
                                                         const Eigen::Isometry3d& T_predicted) {
  std::vector<LandmarkMatch> of_points;
  for (const LandmarkMatch& m : attempt.matches)
    if (!points[static_cast<std::size_t>(m.point)].is_bearing()) of_points.push_back(m);
  const Eigen::Isometry3d& T_start = attempt.consensus ? attempt.consensus->T_world_robot : T_predicted;
  return find_consensus(pair_up(of_points, points, map), T_start, false, settings_.minimum_consensus,
                        ground_random_);
}

FrameAssociator::Attempt FrameAssociator::search(const std::vector<FeaturePoint>& points,
                                                 const std::vector<VisibleLandmark>& visible,
                                                 const FeatureFrame& frame,
                                                 const Eigen::Isometry3d& T_predicted,
                                                 const Matrix6d& covariance, const ParticleMap& map,
                                                 const LandmarkIndex& index) {
  const FastSlamSettings& s = settings_;
  if (visible.empty()) return {};
  Attempt best =
      agree(matcher_.guided(visible, map, index, T_predicted, covariance, s), points, map, T_predicted);
  const bool supported = matcher_.supported();
  // Fewer than half of what is usual: new surroundings, or a slip beyond the gates. The wider search must
  // find clearly more, for its chance matches are more.
  const bool enough = supported && best.consensus && best.inliers() >= 0.5 * usual_inliers_;
  if (!enough) {
    const Matrix6d wide = covariance + slip_covariance(frame, s);
    Attempt attempt =
        agree(matcher_.guided(visible, map, index, T_predicted, wide, s), points, map, T_predicted);
    if (!best.consensus || clearly_more(attempt.inliers(), best.inliers())) best = std::move(attempt);
  }
  if (!best.consensus) {
    Attempt attempt = agree(matcher_.among(visible, map, index, s), points, map, T_predicted);
    if (attempt.consensus) best = std::move(attempt);
  }
  best.supported = supported;
  constexpr double memory = 0.9;
  usual_inliers_ =
      usual_inliers_ > 0 ? memory * usual_inliers_ + (1 - memory) * best.inliers() : best.inliers();
  return best;
}

// After long absence the robot comes back with more drift than any gate covers: what it sees is new by place
// and old by looks. When, step after step, the looks of what matched nothing agree on one pose, and not the
// predicted one, that is where the robot is. What was mapped since at wrong places is not found there again
// and dies by its existence odds.
bool FrameAssociator::close_loop(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                 const ParticleMap& map, const LandmarkIndex& index,
                                 const Eigen::Isometry3d& T_predicted, FrameAssociation& result) {
  const int minimum = 2 * settings_.minimum_consensus;
  if (!settings_.close_loops || static_cast<int>(points.size() - result.matches.size()) < minimum) {
    recognised_ = 0;
    return false;
  }
  matcher_.begin(frame, points, result.matches);
  FrameAssociation recognised = result;
  bool elsewhere = find_back(points, map, index, minimum, recognised);
  if (elsewhere) {
    const Vector6d off = se3_log(T_predicted.inverse() * *recognised.T_world_found);
    elsewhere = off.head<3>().norm() > large_translation || off.tail<3>().norm() > large_rotation;
  }
  recognised_ = elsewhere ? recognised_ + 1 : 0;
  result.doubtful = elsewhere;
  if (recognised_ < settings_.loop_steps) return false;
  recognised_ = 0;
  steps_without_agreement_ = 0;
  result = std::move(recognised);
  result.loop_closed = true;
  return true;
}

bool FrameAssociator::find_back(const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                const LandmarkIndex& index, int minimum, FrameAssociation& result) {
  Attempt found =
      agree(matcher_.everywhere(map, index, settings_), points, map, Eigen::Isometry3d::Identity());
  const auto tried = std::count_if(found.matches.begin(), found.matches.end(), [&](const LandmarkMatch& m) {
    return !points[static_cast<std::size_t>(m.point)].is_bearing();
  });
  // Against a whole map chance agreements exist: most of what matched must agree.
  if (2 * found.inliers() < tried || found.inliers() < minimum || !found.consensus) return false;
  const Consensus& consensus = *found.consensus;
  result.matches = std::move(found.matches);
  result.visible.clear();  // they were expected from elsewhere
  result.rejected.clear();
  keep_agreeing(consensus, points, map, settings_, result);
  result.corrected = true;
  result.T_world_found = consensus.T_world_robot;
  result.prior.covariance = 4 * consensus.covariance;
  result.prior.covariance.diagonal().head<3>().array() += 0.05 * 0.05;
  result.prior.covariance.diagonal().tail<3>().array() += 0.02 * 0.02;
  result.agreed = true;
  result.contradicted = result.doubtful = false;
  return true;
}

}  // namespace lcmslam
