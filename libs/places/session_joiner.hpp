#pragma once
// Where does a new session lie in an old map? Several parts of it (keyframes with motion between them, groups
// of landmarks) must be found in the old map on their own and agree on the answer; one that says otherwise
// must be outvoted.

#include <map>
#include <optional>
#include <vector>

#include <lcmslam/places/place_index.hpp>

namespace lcmslam {

struct JoinSettings {
  int min_agreeing = 3;
  int most_agreeing = 40;
  double min_distance = 0.2;
  double min_angle = 0.2;
  double max_disagreement = 4;
  double floor_translation = 0.03;
  double floor_rotation = 0.02;

  void describe(SettingsVisitor& s) {
    s.number("min_agreeing", min_agreeing, "", {1, 100}, "keyframes that must say the same");
    s.number("most_agreeing", most_agreeing, "", {1, 1000}, "after which nobody is asked any more");
    s.number("min_distance", min_distance, "m", {0, 100},
             "between two of them, so that each is a look of its own");
    s.number("min_angle", min_angle, "rad", {0, 3.1416}, "or of turning");
    s.number("max_disagreement", max_disagreement, "", {0, 1000}, "Mahalanobis distance between two of them");
    s.number("floor_translation", floor_translation, "m", {0, 10},
             "by which both maps bend, added (squared) to the covariance of what one keyframe says");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416},
             "by which both maps bend, added (squared) to the covariance of what one keyframe says");
  }
};

/// Where a session lies.
struct Joint {
  Eigen::Isometry3d T_map_session = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_map_session, right perturbation
  int agreeing = 0, disagreeing = 0;       ///< keyframes that were found in the map
  int asked = 0;                           ///< and all that were looked for
  std::string what = "keyframes";          ///< those are
};

std::string to_string(const Joint& joint);

class SessionJoiner {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit SessionJoiner(const JoinSettings& settings = {}, std::string what = "keyframes");

  /// Looks for a keyframe of the new session in the old map. `id`: by which it may be moved.
  void add(const Eigen::Isometry3d& T_session_camera, const FeatureFrame& features,
           const ColouredCloud& cloud, PlaceIndex& map, std::int32_t id = 0);
  /// A part that lies as near as that was found: another look from there is no look of its own.
  bool knows(const Eigen::Isometry3d& T_session_part) const;
  /// A part of the session that lies there in it was looked for, and found or not.
  void say(const Eigen::Isometry3d& T_session_part, const std::optional<Place>& found, std::int32_t id = 0);
  /// The session's own map has these elsewhere now; where they lie in the old one stays as it was seen.
  void move(const std::map<std::int32_t, Eigen::Isometry3d>& T_session_part);
  /// The session has given these up: nothing moves them any more, and what they say goes with them.
  void drop(const std::vector<std::int32_t>& ids);

  /// Once enough agree.
  const std::optional<Joint>& joint() const { return joint_; }
  /// Nobody more needs to be asked.
  bool done() const { return joint_ && joint_->agreeing >= settings_.most_agreeing; }

 private:
  struct Saying {
    Saying(const Place& found, const JoinSettings& settings, std::int32_t id);
    void place(const Eigen::Isometry3d& T_session_part);

    std::int32_t id;
    Eigen::Isometry3d T_map_part;
    Matrix6d part_covariance;  // of T_map_part
    Eigen::Isometry3d T_session_part, T_map_session;
    Matrix6d covariance;  // of T_map_session
  };
  bool agree(const Saying& a, const Saying& b) const;
  void vote();

  JoinSettings settings_;
  std::string what_;
  std::vector<Saying> sayings_;
  int asked_ = 0;
  std::optional<Joint> joint_;
};

}  // namespace lcmslam
