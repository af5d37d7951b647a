#include <lcmslam/places/landmark_places.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

#include <lcmslam/cloud/voxel_index.hpp>
#include <lcmslam/places/elsewhere.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int fewest_elsewhere = 4;

bool has_descriptor(const Landmark& landmark) {
  const Descriptor& d = landmark.descriptor;
  return std::any_of(d.begin(), d.end(), [&](std::uint8_t byte) { return byte != d[0]; });
}

RigidRansacSettings ransac_settings(int min_inliers) {
  RigidRansacSettings settings;
  settings.min_inliers = min_inliers;
  settings.max_iterations = 20'000;
  return settings;
}

/// Between descriptors of landmarks that look alike.
double limit2(const LandmarkPlaceSettings& settings) {
  const double limit = 127 * settings.max_descriptor_distance;
  return limit * limit;
}

/// Squared, of the bytes.
int distance2(const Descriptor& a, const Descriptor& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0, std::plus<>(),
                            [](int x, int y) { return (x - y) * (x - y); });
}

/// What stands nowhere, or too far away, stands in the middle.
Eigen::Vector3i cell_of(const Eigen::Vector3d& at, const LandmarkPlaceSettings& settings) {
  const auto cells = 1 / static_cast<float>(settings.same_landmark);
  const Eigen::Vector3f point = at.cast<float>();
  return voxel_exists(point, cells) ? voxel_of(point, cells) : Eigen::Vector3i::Zero();
}

/// The map as a whole may be off by far more than a landmark is beside its neighbours: what they share
/// moves the group and does not bend it.
Eigen::Matrix3d beside_neighbours(const Eigen::Matrix3d& covariance, double sigma) {
  const double largest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues()(2);
  return largest > sigma * sigma ? Eigen::Matrix3d(covariance * (sigma * sigma / largest)) : covariance;
}

/// Of those pairs: each landmark once, on either side.
template <class PairList>
std::vector<int> once_each(const std::vector<int>& inliers, const PairList& pairs) {
  std::set<int> askers, landmarks;
  std::vector<int> once;
  for (const int i : inliers) {
    const auto k = static_cast<std::size_t>(i);
    if (askers.count(pairs.asker[k]) + landmarks.count(pairs.landmark[k]) > 0) continue;
    askers.insert(pairs.asker[k]);
    landmarks.insert(pairs.landmark[k]);
    once.push_back(i);
  }
  return once;
}

/// The second of their three standard deviations, m.
double spread(const std::vector<PointPair>& pairs, const std::vector<int>& chosen) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (const int i : chosen) {
    const Eigen::Vector3d& p = pairs[static_cast<std::size_t>(i)].point_b;
    mean += p;
    square += p * p.transpose();
  }
  const auto n = static_cast<double>(chosen.size());
  mean /= n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(square / n - mean * mean.transpose());
  return std::sqrt(std::max(0.0, axes.eigenvalues()(1)));
}

}  // namespace

Landmark transformed(Landmark landmark, const Eigen::Isometry3d& T) {
  landmark.mean = T * landmark.mean;
  landmark.covariance = T.linear() * landmark.covariance * T.linear().transpose();
  return landmark;
}

LandmarkPlaces::LandmarkPlaces(const LandmarkPlaceSettings& settings) : settings_(settings) {
  check(settings, "places of landmarks");
}

void LandmarkPlaces::add(const std::vector<Landmark>& landmarks, const Eigen::Isometry3d& T_map_session,
                         std::int64_t session) {
  const std::size_t before = landmarks_.size();
  for (const Landmark& landmark : landmarks) {
    if (!has_descriptor(landmark)) continue;
    const Landmark there = transformed(landmark, T_map_session);
    if (known(there, before) < static_cast<std::size_t>(settings_.visits)) insert(there, session);
  }
}

void LandmarkPlaces::insert(const Landmark& landmark, std::int64_t session) {
  cells_[voxel_key(cell_of(landmark.mean, settings_))].push_back(landmarks_.size());
  index_.insert(static_cast<int>(landmarks_.size()), landmark.descriptor, landmark.laplacian);
  landmarks_.push_back(landmark);
  sessions_.push_back(session);
}

/// How often it is among those first ones already.
std::size_t LandmarkPlaces::known(const Landmark& landmark, std::size_t before) const {
  std::size_t count = 0;
  const Eigen::Vector3i cell = cell_of(landmark.mean, settings_);
  for (int k = 0; k < 27; ++k) {
    const auto found = cells_.find(voxel_key(cell + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
    if (found == cells_.end()) continue;
    for (const std::size_t i : found->second)
      count += i < before && landmarks_[i].laplacian == landmark.laplacian &&
               (landmarks_[i].mean - landmark.mean).norm() < settings_.same_landmark &&
               distance2(landmarks_[i].descriptor, landmark.descriptor) < limit2(settings_);
  }
  return count;
}

void LandmarkPlaces::drop(std::int64_t session) {
  LandmarkPlaces rest(settings_);
  for (std::size_t i = 0; i < landmarks_.size(); ++i)
    if (sessions_[i] != session) rest.insert(landmarks_[i], sessions_[i]);
  *this = std::move(rest);
}

/// Each one's nearest neighbours: the same thing may be mapped more than once, and stand in more than one
/// place.
LandmarkPlaces::Pairs LandmarkPlaces::alike(const std::vector<Landmark>& group,
                                            const Eigen::Vector3d& middle) {
  std::vector<Feature> queries(group.size());
  for (std::size_t i = 0; i < group.size(); ++i) {
    queries[i].descriptor = group[i].descriptor;
    queries[i].laplacian = group[i].laplacian;
  }
  const std::vector<Neighbours>& neighbours = search_.nearest(queries, index_);
  Pairs pairs;
  for (std::size_t i = 0; i < group.size(); ++i)
    for (const Neighbour& n : neighbours[i]) {
      if (n.id < 0 || n.distance2 > limit2(settings_)) continue;
      const Landmark& known = landmarks_[static_cast<std::size_t>(n.id)];
      pairs.points.push_back({known.mean, group[i].mean - middle,
                              beside_neighbours(known.covariance, settings_.position_sigma),
                              beside_neighbours(group[i].covariance, settings_.position_sigma)});
      pairs.landmark.push_back(n.id);
      pairs.asker.push_back(static_cast<int>(i));
    }
  return pairs;
}

/// How many the best pose elsewhere explains.
int LandmarkPlaces::other_place(const Pairs& pairs, const Eigen::Isometry3d& T_map_group) const {
  const auto is_here = [&](const Eigen::Isometry3d& T) {
    return distance_between(T, T_map_group) <= settings_.same_place_distance &&
           angle_between(T, T_map_group) <= settings_.same_place_angle;
  };
  const std::vector<int> other =
      explained_elsewhere(pairs.points, ransac_settings(fewest_elsewhere), is_here);
  return static_cast<int>(once_each(other, pairs).size());
}

/// What should be there and is not speaks against a place.
double LandmarkPlaces::share_found(const std::vector<Landmark>& group, const Eigen::Isometry3d& T_map_session,
                                   int found) const {
  const double near2 = settings_.near_a_landmark * settings_.near_a_landmark;
  int expected = 0;
  for (const Landmark& landmark : group) {
    const Eigen::Vector3d there = T_map_session * landmark.mean;
    expected += std::any_of(landmarks_.begin(), landmarks_.end(), [&](const Landmark& known) {
      return (known.mean - there).squaredNorm() < near2;
    });
  }
  return expected > 0 ? static_cast<double>(found) / expected : 0;
}

std::string LandmarkPlaces::search(const std::vector<Landmark>& group, LocatedGroup& located) {
  const Pairs pairs = alike(group, located.T_session_group.translation());
  Random random(1);
  const RigidRansacResult best = align_ransac(pairs.points, ransac_settings(settings_.min_inliers), random);
  const std::vector<int> once = once_each(best.inliers, pairs);
  located.inliers = static_cast<int>(once.size());
  Place place{best.T_a_b, best.covariance};
  if (located.inliers < settings_.min_inliers)
    return "only " + std::to_string(located.inliers) + " landmarks that look alike lie alike";
  if (!best.success) return "of landmarks that look alike " + best.reason;
  if (!refine_rigid(pairs.points, once, place.T_map_camera, place.covariance))
    return "landmarks that look alike do not fix the motion";
  if (spread(pairs.points, once) < settings_.min_spread) return "what looks alike is in one spot";
  located.other_inliers = other_place(pairs, place.T_map_camera);
  if (located.inliers < settings_.min_margin * located.other_inliers)
    return "two places look alike: " + std::to_string(located.inliers) + " and " +
           std::to_string(located.other_inliers) + " landmarks";
  located.share = share_found(group, place.T_map_camera * located.T_session_group.inverse(), located.inliers);
  if (located.share < settings_.min_share) return "most of what should be there is not";
  Vector6d floor;
  floor << Eigen::Vector3d::Constant(settings_.floor_translation),
      Eigen::Vector3d::Constant(settings_.floor_rotation);
  place.covariance.diagonal() += floor.cwiseAbs2();
  located.place = place;
  return "";
}

Eigen::Isometry3d LandmarkPlaces::middle_of(const std::vector<Landmark>& group) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  for (const Landmark& landmark : group) T.translation() += landmark.mean / static_cast<double>(group.size());
  return T;
}

LocatedGroup LandmarkPlaces::locate(const std::vector<Landmark>& group) {
  LocatedGroup located;
  std::vector<Landmark> known;
  std::copy_if(group.begin(), group.end(), std::back_inserter(known), has_descriptor);
  located.T_session_group = middle_of(group);
  located.why_not = search(known, located);
  return located;
}

}  // namespace lcmslam
