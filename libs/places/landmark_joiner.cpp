#include <lcmslam/places/landmark_joiner.hpp>

#include <lcmslam/geometry/rigid_alignment.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t fewest_kept = 12;  // of a group's landmarks, to say where it has gone
constexpr double moved_distance = 0.005,
                 moved_angle = 0.005;  // m, rad: less is the noise of single landmarks

}  // namespace

void LandmarkJoiner::add(const std::vector<Landmark>& group, LandmarkPlaces& map) {
  if (joiner_.knows(LandmarkPlaces::middle_of(group))) return;
  const LocatedGroup located = map.locate(group);
  const std::int32_t id = asked_++;
  if (located.place) found_[id] = {group, located.T_session_group};
  joiner_.say(located.T_session_group, located.place, id);
}

bool LandmarkJoiner::move(const std::function<const Landmark*(std::int64_t id)>& find) {
  std::map<std::int32_t, Eigen::Isometry3d> moved;
  for (auto& [id, group] : found_) {
    std::vector<Eigen::Vector3d> from, to;
    for (const Landmark& before : group.landmarks)
      if (const Landmark* now = find(before.id)) {
        from.push_back(before.mean);
        to.push_back(now->mean);
      }
    const RigidAlignment way =
        from.size() < fewest_kept ? RigidAlignment() : SvdEstimator().estimate(from, to);
    const Eigen::Isometry3d T = way.T_target_source * group.T_session_group;
    const bool stays = distance_between(T, group.T_session_group) < moved_distance &&
                       angle_between(T, group.T_session_group) < moved_angle;
    if (!way || stays) continue;
    for (Landmark& landmark : group.landmarks) {
      const Landmark* now = find(landmark.id);
      landmark = now != nullptr ? *now : transformed(landmark, way.T_target_source);
    }
    moved[id] = group.T_session_group = T;
  }
  joiner_.move(moved);
  return !moved.empty();
}

void LandmarkJoiner::add_all(const std::vector<Landmark>& landmarks, LandmarkPlaces& map) {
  auto begin = landmarks.begin();
  while (static_cast<std::size_t>(landmarks.end() - begin) >= group_size && !done()) {
    const auto end = begin + group_size;
    add({begin, end}, map);
    begin = end;
  }
}

}  // namespace lcmslam
