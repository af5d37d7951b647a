#include "fastslam/association.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "fastslam/image_grid.hpp"
#include "surf/matching.hpp"

namespace lcmslam {
namespace {

constexpr int kFar = std::numeric_limits<int>::max();
constexpr int kSearchBudget = 600'000;  // descriptor pairs of a whole-map search: some milliseconds

// The three nearest landmarks of one feature.
struct Nearest {
  std::array<int, 3> distance2{kFar, kFar, kFar};
  std::array<int, 3> landmark{-1, -1, -1};

  void offer(int candidate, int d2) {
    if (d2 >= distance2[2]) return;
    std::size_t i = 2;
    for (; i > 0 && d2 < distance2[i - 1]; --i) {
      distance2[i] = distance2[i - 1];
      landmark[i] = landmark[i - 1];
    }
    distance2[i] = d2;
    landmark[i] = candidate;
  }
};

// Lowe's ratio test; a rival at the winner's own place is the same thing seen twice, no rival.
template <class Position>
bool distinct(const Nearest& nearest, const FastSlamSettings& s, Position position) {
  const double largest = 127 * s.descriptor_distance;
  if (nearest.landmark[0] < 0 || nearest.distance2[0] > largest * largest) return false;
  for (std::size_t rival = 1; rival < 3; ++rival) {
    if (nearest.landmark[rival] < 0) break;
    if ((position(nearest.landmark[rival]) - position(nearest.landmark[0])).norm() < s.same_place) continue;
    return nearest.distance2[0] < s.descriptor_ratio * s.descriptor_ratio * nearest.distance2[rival];
  }
  return true;
}

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
  if (!(feature.point.z() > 0)) return std::nullopt;
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

// A measurement in the robot's plane (see feature.hpp for its noise). It has no descriptor: without an
// identity nothing tells which landmark it shows.
std::optional<FeaturePoint> planar_measurement(const Feature& feature, const FeatureFrame& frame,
                                               const FastSlamSettings& s) {
  if (feature.kind == MeasurementKind::bearing || feature.landmark_id < 0) return std::nullopt;
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
    if (!feature.point.allFinite() || !std::isfinite(feature.x) || !std::isfinite(feature.y) ||
        !std::isfinite(feature.response) || !(feature.depth_sigma > 0))
      continue;
    auto usable = feature.kind == MeasurementKind::point ? camera_point(feature, frame, s)
                                                         : planar_measurement(feature, frame, s);
    if (!usable) continue;
    usable->feature = static_cast<int>(i);
    usable->landmark_id = feature.landmark_id;
    points.push_back(*usable);
  }
  std::sort(points.begin(), points.end(), [&](const FeaturePoint& a, const FeaturePoint& b) {
    const Feature& p = frame.features[static_cast<std::size_t>(a.feature)];
    const Feature& q = frame.features[static_cast<std::size_t>(b.feature)];
    return std::tie(q.response, p.y, p.x, p.landmark_id, p.point.x(), p.point.y(), a.feature) <
           std::tie(p.response, q.y, q.x, q.landmark_id, q.point.x(), q.point.y(), b.feature);
  });
  return points;
}

std::vector<VisibleLandmark> visible_landmarks(const ParticleMap& map, const LandmarkIndex& index,
                                               const Eigen::Isometry3d& T_world_robot,
                                               const FeatureFrame& frame, const FastSlamSettings& s) {
  std::vector<VisibleLandmark> visible;
  const Eigen::Isometry3d T_camera_world = (T_world_robot * frame.T_robot_camera).inverse();
  const double margin = s.visibility_margin * frame.width;
  map.for_each([&](std::size_t i, const LandmarkGaussian& landmark) {
    const int slot = static_cast<int>(i);
    if (slot >= index.slots() || !index.alive(slot) || index.record(slot).known_id >= 0) return;
    const Eigen::Vector3d p = T_camera_world * landmark.mean;
    if (p.z() < 0.5 * s.minimum_range || p.squaredNorm() > 1.21 * s.maximum_range * s.maximum_range) return;
    const double x = frame.fx * p.x() / p.z() + frame.cx;
    const double y = frame.fy * p.y() / p.z() + frame.cy;
    if (x < -margin || x > frame.width + margin || y < -margin || y > frame.height + margin) return;
    visible.push_back({slot, x, y, p.norm(), landmark.mean});
  });
  return visible;
}

std::vector<LandmarkMatch> match_visible(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                         const std::vector<VisibleLandmark>& visible,
                                         const LandmarkIndex& index, double radius,
                                         const FastSlamSettings& s) {
  const ImageGrid grid(frame);
  std::array<std::vector<int>, ImageGrid::kCells> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].landmark_id >= 0) continue;
    const Feature& f = frame.features[static_cast<std::size_t>(points[i].feature)];
    cells[grid.cell(f.x, f.y)].push_back(static_cast<int>(i));
  }

  std::vector<Nearest> of_point(points.size());
  std::vector<int> of_landmark(visible.size(), kFar);  // nearest feature's distance
  for (std::size_t v = 0; v < visible.size(); ++v) {
    const VisibleLandmark& landmark = visible[v];
    const Descriptor& descriptor = index.descriptor(landmark.slot);
    const std::int8_t laplacian = index.record(landmark.slot).laplacian;
    for (int row = grid.row(landmark.y - radius); row <= grid.row(landmark.y + radius); ++row)
      for (int column = grid.column(landmark.x - radius); column <= grid.column(landmark.x + radius);
           ++column)
        for (const int p : cells[static_cast<std::size_t>(row * ImageGrid::kColumns + column)]) {
          const auto at = static_cast<std::size_t>(p);
          const Feature& f = frame.features[static_cast<std::size_t>(points[at].feature)];
          if (f.laplacian != laplacian || std::abs(f.x - landmark.x) > radius ||
              std::abs(f.y - landmark.y) > radius)
            continue;
          const int d2 = squared_distance(f.descriptor, descriptor);
          of_point[at].offer(static_cast<int>(v), d2);
          of_landmark[v] = std::min(of_landmark[v], d2);
        }
  }

  std::vector<LandmarkMatch> matches;
  const auto position = [&](int v) { return visible[static_cast<std::size_t>(v)].mean; };
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (!distinct(of_point[p], s, position)) continue;
    const auto v = static_cast<std::size_t>(of_point[p].landmark[0]);
    if (of_point[p].distance2[0] > of_landmark[v]) continue;  // not mutual
    matches.push_back({static_cast<int>(p), visible[v].slot, of_point[p].distance2[0]});
  }
  return one_to_one(std::move(matches));
}

std::vector<LandmarkMatch> match_known(const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                       const LandmarkIndex& index, const Eigen::Isometry3d& T_world_robot) {
  std::vector<std::pair<double, LandmarkMatch>> candidates;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const int slot = index.find(points[p].landmark_id);
    if (slot < 0) continue;
    const LandmarkGaussian& landmark = *map.find(static_cast<std::size_t>(slot));
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

std::vector<LandmarkMatch> match_all(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                     const ParticleMap& map, const LandmarkIndex& index,
                                     const FastSlamSettings& s, Random& random) {
  std::vector<int> chosen;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].landmark_id < 0) chosen.push_back(static_cast<int>(i));
  const auto affordable = static_cast<std::size_t>(std::max(10, kSearchBudget / std::max(1, index.slots())));
  for (std::size_t i = 0; i + 1 < chosen.size() && i < affordable; ++i)
    std::swap(chosen[i], chosen[i + random.below(chosen.size() - i)]);
  chosen.resize(std::min(chosen.size(), affordable));

  std::vector<LandmarkMatch> matches;
  const auto position = [&](int slot) { return map.find(static_cast<std::size_t>(slot))->mean; };
  for (const int p : chosen) {
    const Feature& f = frame.features[static_cast<std::size_t>(points[static_cast<std::size_t>(p)].feature)];
    Nearest nearest;
    for (int slot = 0; slot < index.slots(); ++slot)
      if (index.record(slot).laplacian == f.laplacian && index.alive(slot) && index.record(slot).known_id < 0)
        nearest.offer(slot, squared_distance(f.descriptor, index.descriptor(slot)));
    if (distinct(nearest, s, position)) matches.push_back({p, nearest.landmark[0], nearest.distance2[0]});
  }
  return one_to_one(std::move(matches));
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
  std::array<std::vector<Candidate>, ImageGrid::kCells> cells;
  for (const LandmarkMatch& match : matches) {
    const FeaturePoint& point = points[static_cast<std::size_t>(match.point)];
    const Feature& f = frame.features[static_cast<std::size_t>(point.feature)];
    const double variance = map.find(static_cast<std::size_t>(match.slot))->covariance.trace() +
                            point.measurement.covariance.trace();
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
