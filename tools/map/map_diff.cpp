#include "tools/map/map_diff.hpp"

#include <algorithm>
#include <map>
#include <tuple>

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

/// Mapper, its process and the how many-th session of that: ids of keyframes and landmarks mean the same
/// there in every file, wherever the session stands in it.
using SessionOrigin = std::tuple<std::string, std::int64_t, int>;

struct NamedSession {
  std::int64_t id = 0;
  std::string name;
};

std::map<SessionOrigin, NamedSession> sessions_by_origin(MapFile& map) {
  std::map<SessionOrigin, NamedSession> found;
  std::map<std::pair<std::string, std::int64_t>, int> begun;
  const auto sessions = map.sessions();
  const auto names = names_of(sessions);
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const auto& [mapper, sender] = std::tie(sessions[i].mapper, sessions[i].sender);
    found[{mapper, sender, ++begun[{mapper, sender}]}] = {sessions[i].id, names[i]};
  }
  return found;
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

std::vector<CommonSession> common_sessions(MapFile& first, MapFile& second) {
  std::vector<CommonSession> common;
  const auto in_second = sessions_by_origin(second);
  for (const auto& [origin, session] : sessions_by_origin(first))
    if (const auto found = in_second.find(origin); found != in_second.end())
      common.push_back({session.name, session.id, found->second.id});
  std::sort(common.begin(), common.end(),
            [](const CommonSession& a, const CommonSession& b) { return a.id_in_first < b.id_in_first; });
  return common;
}

std::vector<SessionDiff> diff_maps(MapFile& first, MapFile& second) {
  std::map<SessionOrigin, SessionDiff> diffs;
  const auto in_first = sessions_by_origin(first), in_second = sessions_by_origin(second);
  for (const auto& [origin, session] : in_second)
    diffs[origin].name = diffs[origin].second_name = session.name;
  for (const auto& [origin, session] : in_first) diffs[origin].name = diffs[origin].first_name = session.name;
  std::vector<SessionDiff> result;
  for (auto& [origin, diff] : diffs) {
    const HeldPlaces a = diff.in_first() ? HeldPlaces(first, in_first.at(origin).id) : HeldPlaces();
    const HeldPlaces b = diff.in_second() ? HeldPlaces(second, in_second.at(origin).id) : HeldPlaces();
    diff.keyframes = count(a.keyframes, b.keyframes);
    diff.landmarks = count(a.landmarks, b.landmarks);
    result.push_back(diff);
  }
  std::sort(result.begin(), result.end(), [](const SessionDiff& a, const SessionDiff& b) {
    return std::tie(a.name, a.second_name) < std::tie(b.name, b.second_name);
  });
  return result;
}

}  // namespace lcmslam
