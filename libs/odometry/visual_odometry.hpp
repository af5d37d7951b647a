#pragma once
// Odometry from the camera alone: SURF matches with depth against the last keyframes, RANSAC, least
// squares. For recordings without wheels.

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct VisualOdometrySettings {
  MatchingSettings matching;
  RigidRansacSettings ransac;

  int keyframes = 4;

  // The current frame becomes a keyframe when it is aligned well and one of these is passed.
  double keyframe_inlier_ratio = 0.5;
  double keyframe_translation = 0.3;
  double keyframe_rotation = 0.35;

  // Tiles look alike a quarter turn on, too: matches that stand where the last motion leads are asked first.
  double expected_within = 0.2;

  // Faster motion is a wrong alignment.
  double max_speed = 3;
  double max_turn_rate = 6;

  // Least squares takes the errors of all features as independent; what they share enters here.
  double covariance_factor = 4;
  double stamp_sigma = 0.005;
  double translation_floor = 0.5e-3;
  double rotation_floor = 0.5e-3;

  // Without an alignment the last velocity goes on for a while. Its error is that of an unknown
  // acceleration: sigma = a t^2 / 2.
  double max_prediction = 0.5;
  double prediction_acceleration = 3;
  double prediction_turn_acceleration = 6;

  void describe(SettingsVisitor& s) {
    s.section("matching", matching, "of a frame's features with a keyframe's");
    s.section("ransac", ransac, "which matches agree on one rigid motion");
    s.number("keyframes", keyframes, "", {1, 100},
             "that a frame is aligned to, at once: 1 drifts more, 10 cost more");
    s.number("keyframe_inlier_ratio", keyframe_inlier_ratio, "", {1e-3, 0.999},
             "a new keyframe is due below this share of the inliers that the newest one had at first");
    s.number("keyframe_translation", keyframe_translation, "m", {1e-3, 100},
             "from the newest keyframe, beyond which a new one is due");
    s.number("keyframe_rotation", keyframe_rotation, "rad", {1e-3, 3.2},
             "from the newest keyframe, beyond which a new one is due");
    s.number("expected_within", expected_within, "m", {0, 1000},
             "of where the last motion leads, a match is asked first, and all others only where too few of "
             "these agree");
    s.number("max_speed", max_speed, "m/s", {0.01, 100}, "faster motion is a wrong alignment");
    s.number("max_turn_rate", max_turn_rate, "rad/s", {0.01, 100}, "faster turning is a wrong alignment");
    s.number("covariance_factor", covariance_factor, "", {1e-3, 1e6},
             "on the alignment's covariance: features share errors that least squares takes as independent");
    s.number("stamp_sigma", stamp_sigma, "s", {1e-9, 1},
             "of stamps and rolling shutter, an error along the motion");
    s.number("translation_floor", translation_floor, "m", {1e-9, 1}, "standard deviation added to each step");
    s.number("rotation_floor", rotation_floor, "rad", {1e-9, 1}, "standard deviation added to each step");
    s.number("max_prediction", max_prediction, "s", {1e-3, 3600},
             "that the last velocity goes on without an alignment; after that the pose stays");
    s.number("prediction_acceleration", prediction_acceleration, "m/s^2", {1e-3, 1000},
             "unknown one, from which a prediction's error comes");
    s.number("prediction_turn_acceleration", prediction_turn_acceleration, "rad/s^2", {1e-3, 1000},
             "unknown one, from which a prediction's error comes");
  }
};

enum class VisualStatus {
  waiting,  ///< no frame yet with enough 3-D points
  tracking,
  degraded,  ///< this pose is a prediction
  lost       ///< the same, for longer than max_prediction
};

struct VisualReport {
  VisualStatus status = VisualStatus::waiting;
  int matches = 0;  ///< with 3-D points on both sides
  int inliers = 0;
  bool new_keyframe = false;
  std::string reason;  ///< why not tracking, empty otherwise
};

class VisualOdometry {
 public:
  /// Throws std::invalid_argument when a setting is wrong.
  VisualOdometry(const VisualOdometrySettings& settings, Random random);

  /// Pose T_odom_robot of the robot frame (frame.T_robot_camera says where the camera is) at the
  /// image's time; `visual` is true. Nothing while waiting, and for a repeated stamp; a stamp that goes
  /// back starts anew at the identity. Features without depth are not used.
  ///
  /// Covariance: two frames aligned to the same keyframes share their errors; what differs, half of
  /// each one's alignment covariance, adds up to one covariance a step. It is right from frame to frame,
  /// and too wide over several frames of one keyframe.
  std::optional<MotionSample> update(const FeatureFrame& frame);

  const VisualReport& report() const { return report_; }

 private:
  struct Reference {
    FeatureFrame frame;  // features with 3-D points only
    Eigen::Isometry3d T_odom_camera = Eigen::Isometry3d::Identity();
    int first_inliers = 0;  // of the first frame aligned to it
  };
  struct Pairs {
    std::vector<PointPair> pairs;  // points in the odometry frame, and in the camera's
    std::size_t newest_begin = 0;  // those of the newest reference come last
    Pairs near(const Eigen::Isometry3d& T_odom_camera, double within) const;
  };
  struct Alignment {
    Eigen::Isometry3d T_odom_camera;
    Eigen::Isometry3d T_odom_robot;
    Matrix6d covariance;     // of the alignment, robot frame
    int newest_inliers = 0;  // with the newest keyframe
  };

  void start(const FeatureFrame& frame);
  std::optional<Alignment> align(const std::vector<const Reference*>& references, const FeatureFrame& frame);
  Pairs match(const std::vector<const Reference*>& references, const FeatureFrame& frame);
  Eigen::Isometry3d expected(Utime utime) const;
  void accept(const Alignment& alignment, Utime utime);
  void predict(Utime utime);
  void add_step(const Eigen::Isometry3d& T_odom_robot, const Matrix6d& Q);
  bool newest_keyframe_is_worn(const Alignment& alignment) const;
  void add_keyframe(const FeatureFrame& frame);
  bool has_enough_points(const FeatureFrame& frame) const;
  Matrix6d prediction_covariance(double seconds) const;
  double seconds_since_aligned(Utime utime) const;

  VisualOdometrySettings settings_;
  Random random_;
  Matcher matcher_;  // keeps its memory
  VisualReport report_;
  std::deque<Reference> keyframes_;    // newest last
  std::optional<Reference> previous_;  // the last aligned frame: second try
  MotionSample sample_;                // newest
  Utime aligned_utime_ = 0;            // of the last aligned frame
  Eigen::Isometry3d T_odom_aligned_ = Eigen::Isometry3d::Identity();
  Vector6d velocity_ = Vector6d::Zero();  // robot frame, m/s and rad/s
};

}  // namespace lcmslam
