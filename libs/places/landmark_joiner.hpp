#pragma once
// Where does a new session's map of landmarks lie in an old one? Groups of landmarks that were born one after
// the other, each of its own landmarks, are looked for on their own (LandmarkPlaces) and must agree
// (SessionJoiner). What was born together was seen together: within a group the map does not bend.

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

  const std::optional<Joint>& joint() const { return joiner_.joint(); }
  bool done() const { return joiner_.done(); }

 private:
  SessionJoiner joiner_;
};

}  // namespace lcmslam
