#include <lcmslam/fastslam/association/association.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include <lcmslam/fastslam/association/image_grid.hpp>
#include <lcmslam/features/matching.hpp>

namespace lcmslam {
namespace {

constexpr double bearing_variance =
    4e-4;  // m^2, rank of a bearing among points in the choice of observations

// The robot's covariance as the camera's: xi_camera = Ad(T_camera_robot) xi_robot.
Matrix6d in_camera(const Matrix6d& covariance, const Eigen::Isometry3d& T_robot_camera) {
  const Matrix6d A = adjoint(T_robot_camera.inverse());
  return A * covariance * A.transpose();
}

// What a camera sees, camera frame: the half-space in front of it and those inside of the four planes through
// its centre and the image's borders, `margin` pixels wider.
class ViewPyramid {
 public:
  ViewPyramid(const FeatureFrame& frame, double margin) {
    const double left = frame.cx + margin, right = frame.width - frame.cx + margin;
    const double top = frame.cy + margin, bottom = frame.height - frame.cy + margin;
    inwards_.row(0) << 0, 0, 1;
    inwards_.row(1) << frame.fx, 0, left;
    inwards_.row(2) << -frame.fx, 0, right;
    inwards_.row(3) << 0, frame.fy, top;
    inwards_.row(4) << 0, -frame.fy, bottom;
    inwards_.rowwise().normalize();
  }
  /// False only if no part of the sphere is in view.
  bool touches(const Eigen::Vector3d& centre, double radius) const {
    return (inwards_ * centre).minCoeff() >= -radius;
  }

 private:
  Eigen::Matrix<double, 5, 3> inwards_;  // unit normals
};

void sort_by_slot(std::vector<LandmarkMatch>& matches) {
  std::sort(matches.begin(), matches.end(),
            [](const LandmarkMatch& a, const LandmarkMatch& b) { return a.slot < b.slot; });
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

// A 3-D point of the camera, told in the robot frame.
std::optional<FeaturePoint> camera_point(const Feature& feature, const FeatureFrame& frame,
                                         const FastSlamSettings& s) {
  if (!feature.point.allFinite() || !(feature.point.z() > 0) || !(feature.depth_sigma > 0))
    return std::nullopt;
  const Eigen::Vector3d point = feature.point.cast<double>();
  FeaturePoint result;
  result.range = point.norm();
  if (result.range < s.minimum_range || result.range > s.maximum_range) return std::nullopt;
  const Eigen::Matrix3d C = point_covariance(feature, frame);
  if (!C.allFinite() || C.diagonal().minCoeff() <= 0) return std::nullopt;
  const Eigen::Matrix3d R = frame.T_robot_camera.linear();
  const Eigen::Matrix3d covariance = s.measurement_inflation * (R * C * R.transpose());
  result.measurement = {frame.T_robot_camera * point, 0.5 * (covariance + covariance.transpose())};
  return result;
}

// A pixel without depth. An identity would need a landmark of the plane.
std::optional<FeaturePoint> camera_bearing(const Feature& feature, const FeatureFrame& frame,
                                           const FastSlamSettings& s) {
  if (!s.use_bearings || feature.landmark_id >= 0) return std::nullopt;
  FeaturePoint result;
  Measurement& m = result.measurement;
  m.kind = MeasurementKind::bearing;
  m.value << (feature.x - frame.cx) / frame.fx, (feature.y - frame.cy) / frame.fy, 0;
  const double u = frame.pixel_sigma / frame.fx, v = frame.pixel_sigma / frame.fy;
  m.covariance.diagonal() << s.measurement_inflation * u * u, s.measurement_inflation * v * v, 1;
  m.T_robot_camera = &frame.T_robot_camera;
  return result;
}

// A measurement in the robot's plane (see feature.hpp for its noise). It has no descriptor: without an
// identity nothing tells which landmark it shows.
std::optional<FeaturePoint> planar_measurement(const Feature& feature, const FeatureFrame& frame,
                                               const FastSlamSettings& s) {
  const bool sound = feature.depth_sigma > 0 && feature.depth_sigma < 1e3F && feature.point.norm() < 1e4F;
  if (feature.landmark_id < 0 || !sound) return std::nullopt;
  FeaturePoint result;
  Measurement& m = result.measurement;
  m.kind = feature.kind;
  m.value << feature.point.cast<double>().head<2>(), 0;
  const double along = feature.depth_sigma;
  const bool polar = feature.kind == MeasurementKind::range_bearing;
  const double across = polar ? frame.pixel_sigma / frame.fx : along;
  result.range = polar ? m.value.x() : m.value.norm();
  if (!(result.range > 0)) return std::nullopt;
  m.covariance.diagonal() << s.measurement_inflation * along * along,
      s.measurement_inflation * across * across, 1;
  return result;
}

}  // namespace

std::vector<FeaturePoint> usable_features(const FeatureFrame& frame, const FastSlamSettings& s) {
  std::vector<FeaturePoint> points;
  if (!(frame.fx > 0 && frame.fy > 0 && frame.pixel_sigma > 0) || !frame.T_robot_camera.matrix().allFinite())
    return points;  // without a calibration nothing is usable
  for (std::size_t i = 0; i < frame.features.size(); ++i) {
    const Feature& feature = frame.features[i];
    if (!std::isfinite(feature.x) || !std::isfinite(feature.y) || !std::isfinite(feature.response)) continue;
    auto usable = feature.kind == MeasurementKind::point     ? camera_point(feature, frame, s)
                  : feature.kind == MeasurementKind::bearing ? camera_bearing(feature, frame, s)
                                                             : planar_measurement(feature, frame, s);
    if (!usable) continue;
    usable->feature = static_cast<int>(i);
    usable->landmark_id = feature.landmark_id;
    points.push_back(*usable);
  }
  std::sort(points.begin(), points.end(), [&](const FeaturePoint& a, const FeaturePoint& b) {
    const Feature& p = frame.features[static_cast<std::size_t>(a.feature)];
    const Feature& q = frame.features[static_cast<std::size_t>(b.feature)];
    const Eigen::Vector3d &u = a.measurement.value, &v = b.measurement.value;
    return std::tie(q.response, p.y, p.x, p.landmark_id, u.x(), u.y(), a.feature) <
           std::tie(p.response, q.y, q.x, q.landmark_id, v.x(), v.y(), b.feature);
  });
  return points;
}

std::vector<VisibleLandmark> visible_landmarks(const LandmarkGrid& grid, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& s) {
  std::vector<VisibleLandmark> visible;
  const Eigen::Isometry3d T_world_camera = T_world_robot * frame.T_robot_camera;
  const Eigen::Isometry3d T_camera_world = T_world_camera.inverse();
  const double margin = s.visibility_margin * frame.width, farthest = 1.1 * s.maximum_range;
  const ViewPyramid pyramid(frame, margin);
  const auto in_view = [&](const Eigen::Vector3d& centre, double radius) {
    const Eigen::Vector3d q = T_camera_world * centre;
    return q.norm() <= farthest + radius && pyramid.touches(q, radius);
  };
  grid.for_each(in_view, [&](const LandmarkGrid::Entry& entry) {
    const Eigen::Vector3d p = T_camera_world * entry.mean;
    if (p.z() < 0.5 * s.minimum_range || p.squaredNorm() > farthest * farthest) return;
    const double x = frame.fx * p.x() / p.z() + frame.cx;
    const double y = frame.fy * p.y() / p.z() + frame.cy;
    if (x < -margin || x > frame.width + margin || y < -margin || y > frame.height + margin) return;
    if (index.alive(entry.slot)) visible.push_back({entry.slot, x, y, p.norm(), entry.mean});
  });
  return visible;
}

std::vector<VisibleLandmark> visible_landmarks(const ParticleMap& map, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& s) {
  LandmarkGrid grid;
  grid.follow(map, index);
  return visible_landmarks(grid, index, T_world_robot, frame, s);
}

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

std::vector<LandmarkMatch> match_known(const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                       const LandmarkIndex& index, const Eigen::Isometry3d& T_world_robot) {
  std::vector<std::pair<double, LandmarkMatch>> candidates;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const int slot = index.find(points[p].landmark_id);
    if (slot < 0) continue;
    const LandmarkGaussian landmark = *map.find(static_cast<std::size_t>(slot));
    candidates.push_back(
        {innovate(landmark, points[p].measurement, T_world_robot).distance2, {static_cast<int>(p), slot, 0}});
  }
  std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second.slot, a.first, a.second.point) <
           std::tie(b.second.slot, b.first, b.second.point);
  });
  std::vector<LandmarkMatch> matches;
  for (const auto& [distance2, match] : candidates)
    if (matches.empty() || matches.back().slot != match.slot) matches.push_back(match);
  return matches;
}

std::vector<LandmarkMatch> select_informative(const std::vector<LandmarkMatch>& matches,
                                              const FeatureFrame& frame,
                                              const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                              const FastSlamSettings& s) {
  const auto wanted = static_cast<std::size_t>(s.maximum_observations);
  if (matches.size() <= wanted) return matches;
  const ImageGrid grid(frame);
  struct Candidate {
    double variance;
    LandmarkMatch match;
  };
  std::array<std::vector<Candidate>, ImageGrid::cell_count> cells;
  for (const LandmarkMatch& match : matches) {
    const FeaturePoint& point = points[static_cast<std::size_t>(match.point)];
    const Feature& f = frame.features[static_cast<std::size_t>(point.feature)];
    // A bearing measures nothing along the ray: it comes after points that are as good across it.
    const double variance = map.find(static_cast<std::size_t>(match.slot))->variance() +
                            (point.is_bearing() ? bearing_variance : point.measurement.covariance.trace());
    cells[grid.cell(f.x, f.y)].push_back({variance, match});
  }
  for (auto& cell : cells)
    std::sort(cell.begin(), cell.end(), [](const Candidate& a, const Candidate& b) {
      return std::tie(a.variance, a.match.slot) < std::tie(b.variance, b.match.slot);
    });
  std::vector<LandmarkMatch> selected;
  for (std::size_t round = 0; selected.size() < wanted; ++round)
    for (const auto& cell : cells)
      if (round < cell.size() && selected.size() < wanted) selected.push_back(cell[round].match);
  sort_by_slot(selected);
  return selected;
}

}  // namespace lcmslam
