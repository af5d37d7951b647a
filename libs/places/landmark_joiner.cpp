#include <lcmslam/places/landmark_joiner.hpp>

namespace lcmslam {

void LandmarkJoiner::add(const std::vector<Landmark>& group, LandmarkPlaces& map) {
  if (joiner_.knows(LandmarkPlaces::middle_of(group))) return;
  const LocatedGroup located = map.locate(group);
  joiner_.say(located.T_session_group, located.place);
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
