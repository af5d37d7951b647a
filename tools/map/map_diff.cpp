#include "tools/map/map_diff.hpp"

#include <map>

namespace lcmslam {
namespace {

struct Moved {
  double distance = 0, angle = 0;
};

Moved moved(const StoredKeyframe& a, const StoredKeyframe& b) {
  if (a.T_map_camera.matrix() == b.T_map_camera.matrix()) return {};
  return {distance_between(a.T_map_camera, b.T_map_camera), angle_between(a.T_map_camera, b.T_map_camera)};
}

Moved moved(const Landmark& a, const Landmark& b) {
  return {(a.mean - b.mean).norm(), 0};
}

/// Both lists by id.
template <class Item>
DiffCount count(const std::vector<Item>& first, const std::vector<Item>& second) {
  DiffCount n;
  auto b = second.begin();
  for (const Item& a : first) {
    for (; b != second.end() && b->id < a.id; ++b) ++n.only_second;
    if (b == second.end() || b->id != a.id) {
      ++n.only_first;
      continue;
    }
    const Moved by = moved(a, *b++);
    ++n.both;
    n.greatest_angle = std::max(n.greatest_angle, by.angle);
    if (by.distance <= n.greatest_distance) continue;
    n.greatest_distance = by.distance;
    n.farthest = a.id;
  }
  n.only_second += second.end() - b;
  return n;
}

std::map<std::string, std::int64_t> ids_by_name(MapFile& map) {
  std::map<std::string, std::int64_t> ids;
  const auto sessions = map.sessions();
  const auto names = names_of(sessions);
  for (std::size_t i = 0; i < sessions.size(); ++i) ids[names[i]] = sessions[i].id;
  return ids;
}

/// Of a session. A map without it may be a file without any table, which must not be asked.
struct HeldPlaces {
  HeldPlaces() = default;
  HeldPlaces(MapFile& map, std::int64_t session)
      : keyframes(map.keyframes(session)), landmarks(map.landmarks(session)) {}
  std::vector<StoredKeyframe> keyframes;
  std::vector<Landmark> landmarks;
};

}  // namespace

std::vector<SessionDiff> diff_maps(MapFile& first, MapFile& second) {
  std::map<std::string, SessionDiff> diffs;
  const auto in_first = ids_by_name(first), in_second = ids_by_name(second);
  for (const auto& [name, id] : in_first) diffs[name].in_first = true;
  for (const auto& [name, id] : in_second) diffs[name].in_second = true;
  std::vector<SessionDiff> result;
  for (auto& [name, diff] : diffs) {
    diff.name = name;
    const HeldPlaces a = diff.in_first ? HeldPlaces(first, in_first.at(name)) : HeldPlaces();
    const HeldPlaces b = diff.in_second ? HeldPlaces(second, in_second.at(name)) : HeldPlaces();
    diff.keyframes = count(a.keyframes, b.keyframes);
    diff.landmarks = count(a.landmarks, b.landmarks);
    result.push_back(diff);
  }
  return result;
}

}  // namespace lcmslam
