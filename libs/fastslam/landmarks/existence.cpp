#include <lcmslam/fastslam/landmarks/existence.hpp>

#include <algorithm>
#include <array>
#include <set>

#include <lcmslam/fastslam/association/visibility.hpp>

namespace lcmslam {
namespace {

constexpr Utime long_ago = 15'000'000;  // us: what is older is of a former visit, or the robot stands

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
  if (!settings.remove_landmarks) return index.age(settings);  // of those none is tentative
  int died = 0;
  for (const int slot : contradicted) died += index.miss(slot, settings);

  const LandmarkVisibility visibility(frame, points, T_world_robot);
  died += index.age(settings);
  for (const VisibleLandmark& landmark : visible) {
    if (seen[static_cast<std::size_t>(landmark.slot)] || !index.alive(landmark.slot)) continue;
    if (!visibility.ought_to_show(landmark, index.record(landmark.slot))) continue;
    died += index.miss(landmark.slot, settings);
  }
  return died;
}

std::vector<int> choose_new_landmarks(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                      const std::vector<VisibleLandmark>& visible,
                                      const std::vector<LandmarkMatch>& matches, const LandmarkIndex& index,
                                      const Eigen::Isometry3d& T_world_robot,
                                      const FastSlamSettings& settings) {
  const ImageGrid grid(frame);
  std::array<int, ImageGrid::cell_count> occupied{};
  std::vector<char> taken(points.size(), 0), matched(static_cast<std::size_t>(index.slots()), 0);
  const auto is_of_former_visit = [&](int slot) { return frame.utime - index.record(slot).born > long_ago; };
  const int half = settings.maximum_observations / 2;
  int recognised = 0;
  for (const LandmarkMatch& match : matches) {
    const auto p = static_cast<std::size_t>(match.point);
    taken[p] = 1;
    matched[static_cast<std::size_t>(match.slot)] = 1;
    if (is_of_former_visit(match.slot)) ++recognised;
    const Feature& f = feature_of(frame, points[p]);
    ++occupied[grid.cell(f.x, f.y)];
  }
  if (static_cast<int>(matches.size()) >= half) {
    const LandmarkVisibility visibility(frame, points, T_world_robot);
    for (const VisibleLandmark& landmark : visible)
      if (!matched[static_cast<std::size_t>(landmark.slot)] && index.alive(landmark.slot) &&
          is_of_former_visit(landmark.slot) && visibility.is_free(landmark))
        ++occupied[visibility.cell(landmark)];
  }
  const int capacity = recognised >= half ? 1 : settings.cell_capacity;
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
    if (here >= capacity) continue;
    ++here;
    chosen.push_back(static_cast<int>(p));
  }
  return chosen;
}

}  // namespace lcmslam
