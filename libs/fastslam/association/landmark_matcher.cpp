#include <lcmslam/fastslam/association/landmark_matcher.hpp>

#include <algorithm>
#include <tuple>

#include <lcmslam/features/matching.hpp>

namespace lcmslam {
namespace {

// The robot's covariance as the camera's: xi_camera = Ad(T_camera_robot) xi_robot.
Matrix6d in_camera(const Matrix6d& covariance, const Eigen::Isometry3d& T_robot_camera) {
  const Matrix6d A = adjoint(T_robot_camera.inverse());
  return A * covariance * A.transpose();
}

// Keeps the nearest feature of each landmark: an observation is one to one.
std::vector<LandmarkMatch> one_to_one(std::vector<LandmarkMatch> matches) {
  std::sort(matches.begin(), matches.end(), [](const LandmarkMatch& a, const LandmarkMatch& b) {
    return std::tie(a.slot, a.distance2, a.point) < std::tie(b.slot, b.distance2, b.point);
  });
  matches.erase(std::unique(matches.begin(), matches.end(),
                            [](const LandmarkMatch& a, const LandmarkMatch& b) { return a.slot == b.slot; }),
                matches.end());
  return matches;
}

}  // namespace

void LandmarkMatcher::begin(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                            const std::vector<LandmarkMatch>& matched) {
  std::vector<char> skip(points.size(), 0);
  for (const LandmarkMatch& m : matched) skip[static_cast<std::size_t>(m.point)] = 1;
  std::vector<Feature> features = std::move(sought_.features);
  features.clear();
  point_of_.clear();
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (points[p].landmark_id >= 0 || skip[p]) continue;
    features.push_back(frame.features[static_cast<std::size_t>(points[p].feature)]);
    point_of_.push_back(static_cast<int>(p));
  }
  sought_.utime = frame.utime;
  sought_.width = frame.width;
  sought_.height = frame.height;
  sought_.fx = frame.fx;
  sought_.fy = frame.fy;
  sought_.cx = frame.cx;
  sought_.cy = frame.cy;
  sought_.pixel_sigma = frame.pixel_sigma;
  sought_.T_robot_camera = frame.T_robot_camera;
  sought_.features = std::move(features);
}

std::vector<LandmarkMatch> LandmarkMatcher::guided(const std::vector<VisibleLandmark>& visible,
                                                   const ParticleMap& map, const LandmarkIndex& index,
                                                   const Eigen::Isometry3d& T_world_robot,
                                                   const Matrix6d& covariance, const FastSlamSettings& s) {
  supported_ = false;
  if (sought_.features.empty() || sought_.width <= 0 || sought_.height <= 0) return {};
  points_.clear();
  stored_.clear();
  for (const VisibleLandmark& v : visible) stored_.push_back(map.prefetch(static_cast<std::size_t>(v.slot)));
  for (std::size_t i = 0; i < visible.size(); ++i)
    points_.push_back({visible[i].slot, visible[i].mean, stored_[i]->covariance()});
  PredictedPose pose;
  pose.T_world_camera = T_world_robot * sought_.T_robot_camera;
  pose.covariance = in_camera(covariance, sought_.T_robot_camera);
  GuidedSettings settings;
  settings.max_gate = std::max(settings.max_gate, 3 * s.search_radius * sought_.width);
  settings.ratio = s.descriptor_ratio;
  settings.max_distance = s.descriptor_distance;
  settings.same_place = s.same_place;
  settings.margin = s.visibility_margin * sought_.width;
  const GuidedResult& found = guided_.match(sought_, pose, points_, index.search(), settings);
  supported_ = found.supported();
  std::vector<LandmarkMatch> matches;
  for (const Match& m : found.matches)
    matches.push_back({point_of_[static_cast<std::size_t>(m.a)], m.b, m.distance2});
  sort_by_slot(matches);
  return matches;
}

std::vector<LandmarkMatch> LandmarkMatcher::among(const std::vector<VisibleLandmark>& visible,
                                                  const ParticleMap& map, const LandmarkIndex& index,
                                                  const FastSlamSettings& s) {
  slots_.clear();
  for (const VisibleLandmark& v : visible) slots_.push_back(v.slot);
  return distinct(search_.nearest(sought_.features, index.search(), slots_), map, s);
}

std::vector<LandmarkMatch> LandmarkMatcher::everywhere(const ParticleMap& map, const LandmarkIndex& index,
                                                       const FastSlamSettings& s) {
  return distinct(search_.nearest(sought_.features, index.search()), map, s);
}

// Lowe's ratio test; a rival at the winner's own place is the same thing seen twice, no rival.
std::vector<LandmarkMatch> LandmarkMatcher::distinct(const std::vector<Neighbours>& nearest,
                                                     const ParticleMap& map,
                                                     const FastSlamSettings& s) const {
  const double largest = 127 * s.descriptor_distance;
  const auto mean = [&](const Neighbour& n) { return map.find(static_cast<std::size_t>(n.id))->mean; };
  std::vector<LandmarkMatch> matches;
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const Neighbour& first = nearest[i][0];
    if (first.id < 0 || first.distance2 > largest * largest) continue;
    bool clear = true;
    for (std::size_t rival = 1; rival < 3 && nearest[i][rival].id >= 0; ++rival) {
      if ((mean(nearest[i][rival]) - mean(first)).norm() < s.same_place) continue;
      clear = passes_ratio(first.distance2, nearest[i][rival].distance2, s.descriptor_ratio);
      break;
    }
    if (clear) matches.push_back({point_of_[i], first.id, first.distance2});
  }
  return one_to_one(std::move(matches));
}

}  // namespace lcmslam
