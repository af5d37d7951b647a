#include <lcmslam/places/place_index.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <set>
#include <sstream>

#include <lcmslam/features/strongest_features.hpp>
#include <lcmslam/places/elsewhere.hpp>
#include <lcmslam/places/view_agreement.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr double length_of_a_turn = 1;  // m/rad, when poses are told near
constexpr int least_other_inliers = 4;
constexpr double enough_views = 3;  // m of such a length; who is farther sees something else

double away(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return distance_between(a, b) + length_of_a_turn * angle_between(a, b);
}

/// Those by which a place can be found: they have a point.
FeatureFrame with_points(FeatureFrame frame, int count) {
  if (!(frame.fx > 0 && frame.fy > 0 && frame.pixel_sigma > 0)) frame.features.clear();
  const auto no_point = [](const Feature& f) {
    return f.kind != MeasurementKind::point || !f.point.allFinite() || !(f.point.z() > 0) ||
           !(f.depth_sigma > 0);
  };
  frame.features.erase(std::remove_if(frame.features.begin(), frame.features.end(), no_point),
                       frame.features.end());
  return strongest(std::move(frame), count);
}

Matrix6d squares(double translation, double rotation) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(translation), Eigen::Vector3d::Constant(rotation);
  return sigmas.cwiseAbs2().asDiagonal();
}

/// The asker's cloud as registration takes it; its features' points where there is none.
Cloud cloud_of(const ColouredCloud& cloud, const FeatureFrame& features, double voxel) {
  if (cloud.size() > 0) return voxel_filtered(geometry_of(cloud), voxel);
  Cloud points;
  for (const Feature& f : features.features) points.points.push_back(f.point);
  return points;
}

/// Of those pairs: each of the asker's features once, with the first that it has.
std::vector<int> one_a_feature(const std::vector<int>& inliers, const std::vector<int>& feature) {
  std::set<int> seen;
  std::vector<int> once;
  for (const int i : inliers)
    if (seen.insert(feature[static_cast<std::size_t>(i)]).second) once.push_back(i);
  return once;
}

/// What two say of one pose, each with the floor.
Place both(const UncertainTransform& a, const UncertainTransform& b, const Matrix6d& floor) {
  const Matrix6d information_a = (a.covariance + floor).inverse(),
                 information_b = (b.covariance + floor).inverse();
  const Matrix6d covariance = (information_a + information_b).inverse();
  const Vector6d step = covariance * information_b * se3_log(a.T.inverse() * b.T);
  return {a.T * se3_exp(step), covariance + floor};
}

/// The smaller of the two standard deviations of where they are in the image, as a share of its width.
double spread(const FeatureFrame& frame, const std::vector<int>& features) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  for (const int i : features) {
    const Feature& f = frame.features[static_cast<std::size_t>(i)];
    const Eigen::Vector2d at(static_cast<double>(f.x), static_cast<double>(f.y));
    mean += at;
    square += at * at.transpose();
  }
  const auto n = static_cast<double>(features.size());
  mean /= n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(square / n - mean * mean.transpose());
  return std::sqrt(std::max(0.0, axes.eigenvalues()(0))) / std::max(1, frame.width);
}

}  // namespace

std::string to_string(const PlaceEvidence& e) {
  std::ostringstream text;
  text.precision(2);
  text << e.inliers << " features (another place " << e.other_inliers << ") of " << e.keyframes.size()
       << " keyframes, overlap " << e.overlap << ", " << 1000 * e.rms << " mm between surfaces, seen through "
       << 100 * e.seen_through << " %";
  return text.str();
}

PlaceIndex::PlaceIndex(const PlaceSettings& settings) : settings_(settings) {
  check(settings, "places");
}

void PlaceIndex::add(std::int64_t key, const Eigen::Isometry3d& T_map_camera, const FeatureFrame& features,
                     const ColouredCloud& cloud) {
  add(key, View{T_map_camera,
                with_points(features, settings_.indexed_features),
                voxel_filtered(geometry_of(cloud), settings_.cloud_voxel),
                {},
                0});
}

/// Each feature votes for the keyframes of its nearest neighbours. `without`: slots that are left out.
std::vector<std::int64_t> PlaceIndex::most_voted(const FeatureFrame& asker,
                                                 const std::vector<bool>& without) {
  if (index_.size() == 0) return {};
  const double limit = 127 * settings_.max_descriptor_distance;
  std::map<std::int64_t, int> votes;
  for (const Neighbours& neighbours : search_.nearest_without(without, asker.features, index_)) {
    std::set<std::int64_t> keys;
    for (const Neighbour& n : neighbours)
      if (n.id >= 0 && n.distance2 <= limit * limit)
        keys.insert(key_of_slot_[static_cast<std::size_t>(n.id)]);
    for (const std::int64_t key : keys) ++votes[key];
  }
  std::vector<std::int64_t> keys;
  for (const auto& [key, count] : votes)
    if (count >= settings_.min_votes) keys.push_back(key);
  std::stable_sort(keys.begin(), keys.end(),
                   [&](std::int64_t a, std::int64_t b) { return votes.at(a) > votes.at(b); });
  return keys;
}

/// By votes among those alone that stand elsewhere: where a place was mapped often it has all others.
std::vector<std::int64_t> PlaceIndex::most_voted_elsewhere(const FeatureFrame& asker,
                                                           const Eigen::Isometry3d& T_map_camera) {
  std::vector<bool> here(key_of_slot_.size());
  for (const auto& [key, view] : views_)
    if (away(view.T_map_camera, T_map_camera) <= enough_views)
      for (const int slot : view.slots) here[static_cast<std::size_t>(slot)] = true;
  return most_voted(asker, here);
}

/// Points that the first of these keyframes and the asker share, the keyframes' in the map's frame.
PlaceIndex::Pairs PlaceIndex::match(const FeatureFrame& asker, const std::vector<std::int64_t>& keys) {
  Pairs pairs;
  const Eigen::Matrix3d map_noise = settings_.map_sigma * settings_.map_sigma * Eigen::Matrix3d::Identity();
  const std::size_t count = std::min(keys.size(), static_cast<std::size_t>(settings_.candidates));
  for (std::size_t k = 0; k < count; ++k) {
    const std::int64_t key = keys[k];
    const View& view = views_.at(key);
    const Eigen::Matrix3d R = view.T_map_camera.linear();
    for (const Match& m : matcher_.match(view.features.features, asker.features)) {
      const Feature& a = view.features.features[static_cast<std::size_t>(m.a)];
      const Feature& b = asker.features[static_cast<std::size_t>(m.b)];
      pairs.points.push_back({view.T_map_camera * a.point.cast<double>(), b.point.cast<double>(),
                              R * point_covariance(a, view.features) * R.transpose() + map_noise,
                              point_covariance(b, asker)});
      pairs.feature.push_back(m.b);
      pairs.view.push_back(key);
    }
  }
  return pairs;
}

/// What the map has around there, in its own frame: clouds of the nearest keyframes.
Cloud PlaceIndex::pool(const Eigen::Isometry3d& T_map_camera) const {
  std::vector<std::pair<double, const View*>> near;
  for (const auto& [key, view] : views_) {
    const double distance = away(view.T_map_camera, T_map_camera);
    if (distance < enough_views) near.emplace_back(distance, &view);
  }
  std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (near.size() > static_cast<std::size_t>(settings_.pooled_views))
    near.resize(static_cast<std::size_t>(settings_.pooled_views));
  Cloud pooled;
  for (const auto& [distance, view] : near) {
    const Cloud moved = transformed(view->cloud, view->T_map_camera);
    pooled.points.insert(pooled.points.end(), moved.points.begin(), moved.points.end());
    if (moved.has_normals())
      pooled.normals.insert(pooled.normals.end(), moved.normals.begin(), moved.normals.end());
  }
  // Normals of some alone would not fit the points.
  if (pooled.normals.size() != pooled.points.size()) pooled.normals.clear();
  return voxel_filtered(pooled, settings_.cloud_voxel);
}

// Each of these says why the asker is nowhere; empty: nothing speaks against it.

/// One pose explains the matched points, and they are all over the image.
std::string PlaceIndex::explain(const FeatureFrame& asker, const Pairs& pairs, PlaceEvidence& evidence,
                                UncertainTransform& pose) const {
  RigidRansacSettings ransac;
  ransac.min_inliers = settings_.min_inliers;
  Random random(1);
  const RigidRansacResult best = align_ransac(pairs.points, ransac, random);
  const std::vector<int> once = one_a_feature(best.inliers, pairs.feature);
  evidence.inliers = static_cast<int>(once.size());
  pose.T = best.T_a_b;
  if (evidence.inliers < settings_.min_inliers)
    return "keyframes look alike, but only " + std::to_string(evidence.inliers) + " points lie alike";
  if (!best.success) return "keyframes look alike, but " + best.reason;
  if (!refine_rigid(pairs.points, once, pose.T, pose.covariance))
    return "keyframes look alike, but their points do not fix the motion";
  std::set<std::int64_t> keys;
  for (const int i : best.inliers) keys.insert(pairs.view[static_cast<std::size_t>(i)]);
  evidence.keyframes.assign(keys.begin(), keys.end());
  std::vector<int> explained;
  explained.reserve(once.size());
  for (const int i : once) explained.push_back(pairs.feature[static_cast<std::size_t>(i)]);
  return spread(asker, explained) < settings_.min_spread ? "what looks alike is in one spot of the image"
                                                         : "";
}

/// Far more of them than another place does. `keys`: keyframes that look alike, wherever they stand.
std::string PlaceIndex::look_elsewhere(const FeatureFrame& asker, const std::vector<std::int64_t>& keys,
                                       const Eigen::Isometry3d& T_map_camera, PlaceEvidence& evidence) {
  std::vector<std::int64_t> others = most_voted_elsewhere(asker, T_map_camera);
  std::copy_if(keys.begin(), keys.end(), std::back_inserter(others), [&](std::int64_t key) {
    const bool agrees = std::binary_search(evidence.keyframes.begin(), evidence.keyframes.end(), key);
    return !agrees && away(views_.at(key).T_map_camera, T_map_camera) <= enough_views;
  });
  const Pairs pairs = match(asker, others);
  RigidRansacSettings ransac;
  ransac.min_inliers = least_other_inliers;
  const auto is_here = [&](const Eigen::Isometry3d& T) {
    return distance_between(T, T_map_camera) <= settings_.same_place_distance &&
           angle_between(T, T_map_camera) <= settings_.same_place_angle;
  };
  const std::vector<int> other = explained_elsewhere(pairs.points, ransac, is_here);
  const auto explained = static_cast<int>(one_a_feature(other, pairs.feature).size());
  evidence.other_inliers = std::max(evidence.other_inliers, explained);
  if (evidence.inliers >= settings_.min_margin * evidence.other_inliers) return "";
  return "two places look alike: " + std::to_string(evidence.inliers) + " and " +
         std::to_string(evidence.other_inliers) + " points";
}

/// The surfaces lie on each other where the features say, and nothing of the map is where the asker looks
/// through.
std::string PlaceIndex::fit_surfaces(const FeatureFrame& asker, const Cloud& seen,
                                     const UncertainTransform& pose, Located& located) const {
  PlaceEvidence& evidence = located.evidence;
  const Matrix6d floor = squares(settings_.floor_translation, settings_.floor_rotation);
  const Matrix6d tolerance = squares(settings_.tolerance_translation, settings_.tolerance_rotation);
  const Cloud map = pool(pose.T);
  const Prior prior{pose.T, (pose.covariance + floor).inverse()};
  const KdTreeTarget target(prepared_target(map, settings_.registration, pose.T.translation()));
  const RegistrationResult fit = register_cloud(seen, target, pose.T, settings_.registration, &prior);
  evidence.overlap = fit.overlap;
  evidence.inlier_share = fit.pairs > 0 ? static_cast<double>(fit.inliers) / fit.pairs : 0;
  evidence.rms = fit.rms.empty() ? 0 : fit.rms.back();
  if (!fit.ok() || fit.overlap < settings_.min_overlap || evidence.inlier_share < settings_.min_inlier_share)
    return "features agree, surfaces do not";
  if (distance_from_identity({pose.T.inverse() * fit.T_target_source, pose.covariance + tolerance}) >
      settings_.max_disagreement)
    return "features and surfaces say different poses";
  const ViewAgreement agreement = compare_views(transformed(map, fit.T_target_source.inverse()), seen, asker);
  evidence.seen_through = agreement.seen_through;
  evidence.agrees = agreement.agrees;
  if (evidence.seen_through > settings_.max_seen_through)
    return "the map has surfaces where one sees through";
  if (agreement.compared > 0 && evidence.agrees < settings_.min_agreement)
    return "the map's surfaces are nearer or farther than what is seen";
  const double counted = std::min<double>(fit.pairs, settings_.registration.independent_pairs);
  const Matrix6d of_surfaces = std::max(1.0, counted / settings_.surface_pairs) * fit.covariance;
  located.place = both(pose, {fit.T_target_source, of_surfaces}, floor);
  return "";
}

std::string PlaceIndex::search(const FeatureFrame& asker, const ColouredCloud& cloud, Located& located) {
  if (asker.features.size() < static_cast<std::size_t>(settings_.min_inliers))
    return "only " + std::to_string(asker.features.size()) + " features have a point";
  const std::vector<std::int64_t> keys = most_voted(asker);
  if (keys.empty()) return "no keyframe looks alike";
  UncertainTransform pose;
  std::string why_not = explain(asker, match(asker, keys), located.evidence, pose);
  if (why_not.empty()) why_not = look_elsewhere(asker, keys, pose.T, located.evidence);
  if (why_not.empty())
    why_not = fit_surfaces(asker, cloud_of(cloud, asker, settings_.cloud_voxel), pose, located);
  return why_not;
}

Located PlaceIndex::locate(const FeatureFrame& features, const ColouredCloud& cloud) {
  Located located;
  located.why_not = search(with_points(features, settings_.indexed_features), cloud, located);
  return located;
}

void PlaceIndex::look_for_twin(const FeatureFrame& features, const Eigen::Isometry3d& T_this_other,
                               Located& located) {
  if (!located.place) return;
  const FeatureFrame asker = with_points(features, settings_.indexed_features);
  PlaceEvidence& evidence = located.evidence;
  const std::vector<std::int64_t> of_other = std::exchange(evidence.keyframes, {});
  located.why_not =
      look_elsewhere(asker, most_voted(asker), T_this_other * located.place->T_map_camera, evidence);
  evidence.keyframes = of_other;
  if (!located.why_not.empty()) located.place.reset();
}

}  // namespace lcmslam
