#include <lcmslam/fastslam/landmarks/existence.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <lcmslam/fastslam/association/image_grid.hpp>

namespace lcmslam {
namespace {

constexpr double same_view_cosine =
    0.87;                           // within 30 degrees of the last observation SURF should find it again
constexpr double same_scale = 1.5;  // and within this factor of its distance

const Feature& feature_of(const FeatureFrame& frame, const FeaturePoint& point) {
  return frame.features[static_cast<std::size_t>(point.feature)];
}

}  // namespace

int update_existence(LandmarkIndex& index, const ParticleMap& map, const FeatureFrame& frame,
                     const std::vector<FeaturePoint>& points, const std::vector<VisibleLandmark>& visible,
                     const std::vector<LandmarkMatch>& matches, const std::vector<int>& contradicted,
                     const Eigen::Isometry3d& T_world_robot, const FastSlamSettings& settings) {
  const Eigen::Vector3d camera = T_world_robot * frame.T_robot_camera.translation();
  std::vector<char> seen(static_cast<std::size_t>(index.slots()), 0);
  for (const LandmarkMatch& match : matches) {
    const auto slot = static_cast<std::size_t>(match.slot);
    seen[slot] = 1;
    index.observe(match.slot, feature_of(frame, points[static_cast<std::size_t>(match.point)]), settings);
    const Eigen::Vector3d ray = camera - map.find(slot)->mean;
    index.record(match.slot).seen_from = ray.normalized();
    index.record(match.slot).seen_at = ray.norm();
  }
  if (!settings.remove_landmarks) return 0;
  int died = 0;
  for (const int slot : contradicted) died += index.miss(slot, settings);

  const ImageGrid grid(frame);
  std::array<double, ImageGrid::cell_count> farthest{};  // measured in each cell
  for (const FeaturePoint& point : points) {
    const Feature& f = feature_of(frame, point);
    double& cell = farthest[grid.cell(f.x, f.y)];
    cell = std::max(cell, point.range);
  }
  died += index.age(settings);
  for (const VisibleLandmark& landmark : visible) {
    if (seen[static_cast<std::size_t>(landmark.slot)] || !index.alive(landmark.slot)) continue;
    if (landmark.x < 0 || landmark.x >= frame.width || landmark.y < 0 || landmark.y >= frame.height) continue;
    if (farthest[grid.cell(landmark.x, landmark.y)] < 0.95 * landmark.range) continue;  // hidden, or unknown
    const LandmarkRecord& record = index.record(landmark.slot);
    if (record.seen_at > 0) {
      const Eigen::Vector3d ray = camera - landmark.mean;
      const double scale = ray.norm() / record.seen_at;
      if (ray.normalized().dot(record.seen_from) < same_view_cosine) continue;
      if (scale > same_scale || scale < 1 / same_scale) continue;
    }
    died += index.miss(landmark.slot, settings);
  }
  return died;
}

std::vector<int> choose_new_landmarks(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                      const std::vector<LandmarkMatch>& matches, const LandmarkIndex& index,
                                      const FastSlamSettings& settings) {
  const ImageGrid grid(frame);
  std::array<int, ImageGrid::cell_count> occupied{};
  std::vector<char> taken(points.size(), 0);
  for (const LandmarkMatch& match : matches) {
    const auto p = static_cast<std::size_t>(match.point);
    taken[p] = 1;
    const Feature& f = feature_of(frame, points[p]);
    ++occupied[grid.cell(f.x, f.y)];
  }
  std::vector<int> chosen;
  std::set<std::int32_t> identities;  // one may be read twice in a frame
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (const std::int32_t id = points[p].landmark_id; id >= 0) {
      if (index.find(id) < 0 && identities.insert(id).second) chosen.push_back(static_cast<int>(p));
      continue;
    }
    if (points[p].is_bearing() || taken[p] ||
        static_cast<int>(chosen.size()) >= settings.maximum_new_landmarks)
      continue;
    const Feature& f = feature_of(frame, points[p]);
    int& here = occupied[grid.cell(f.x, f.y)];
    if (here >= settings.cell_capacity) continue;
    ++here;
    chosen.push_back(static_cast<int>(p));
  }
  return chosen;
}

}  // namespace lcmslam
