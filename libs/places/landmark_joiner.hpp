#pragma once
// Where does a new session's map of landmarks lie in an old one? Groups of landmarks that were born one after
// the other, each of its own landmarks, are looked for on their own (LandmarkPlaces) and must agree
// (SessionJoiner). What was born together was seen together: within a group the map does not bend.

#include <functional>

#include <lcmslam/places/landmark_places.hpp>
#include <lcmslam/places/session_joiner.hpp>

namespace lcmslam {

class LandmarkJoiner {
 public:
  static constexpr std::size_t group_size = 60;
  /// Groups of one view are one look: what agrees must lie apart.
  static JoinSettings defaults() {
    JoinSettings settings;
    settings.min_distance = 0.4;
    settings.most_agreeing = 12;
    return settings;
  }

  explicit LandmarkJoiner(const JoinSettings& settings = defaults())
      : joiner_(settings, "groups of landmarks") {}

  /// Looks for a group in the old map.
  void add(const std::vector<Landmark>& group, LandmarkPlaces& map);
  /// All groups of a whole map, which is ordered by id, as long as somebody needs to be asked.
  void add_all(const std::vector<Landmark>& landmarks, LandmarkPlaces& map);

  /// The session's map has its landmarks elsewhere now; where the groups that were found lie in the old one
  /// stays as it was seen. `find` gives a landmark of today, or nullptr. True when a group has moved.
  bool move(const std::function<const Landmark*(std::int64_t id)>& find);

  const std::optional<Joint>& joint() const { return joiner_.joint(); }
  bool done() const { return joiner_.done(); }

 private:
  struct Group {
    std::vector<Landmark> landmarks;  // as they were when T was said
    Eigen::Isometry3d T_session_group;
  };
  SessionJoiner joiner_;
  std::map<std::int32_t, Group> found_;
  std::int32_t asked_ = 0;
};

}  // namespace lcmslam
