#pragma once
// From a recording's frames to what it shows of the head: keyframes on the path that visual odometry saw, and
// the landmarks that their SURF features agree on, for calibrate_head().
//
//   RecordedScene recording(calibration, settings);
//   for (each frame) recording.add(frame);
//   SceneObservations scene = recording.observations();

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <lcmslam/calibration/self/scene_observations.hpp>
#include <lcmslam/features/feature.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/odometry/camera_turn.hpp>
#include <lcmslam/odometry/visual_odometry.hpp>

namespace lcmslam {

struct RecordedSceneSettings {
  int max_features = 700;
  int keyframes = 240;
  double keyframe_translation = 0.12, keyframe_rotation = 0.12;
  double velocity_window = 0.07;
  double wheel_turn_noise = 0.03, image_turn_noise = 0.1;
  int neighbours = 5, others = 6;
  double view_distance = 1.2, view_angle = 0.6;
  double match_gate = 10;
  int landmarks = 5000;
  std::uint64_t seed = 1;

  void describe(SettingsVisitor& s) {
    s.number("max_features", max_features, "", {50, 5000}, "keypoints of an image");
    s.number("keyframes", keyframes, "", {5, 1000},
             "at most: of more so many are taken, evenly; while it reads three times as many are kept");
    s.number("keyframe_translation", keyframe_translation, "m", {1e-3, 10}, "from keyframe to keyframe");
    s.number("keyframe_rotation", keyframe_rotation, "rad", {1e-3, 3}, "from keyframe to keyframe");
    s.number("velocity_window", velocity_window, "s", {1e-3, 1},
             "to each side, over which the camera's velocity is taken");
    s.number("wheel_turn_noise", wheel_turn_noise, "rad/s", {0, 10}, "of turn rates that wheels tell");
    s.number("image_turn_noise", image_turn_noise, "rad/s", {0, 10},
             "of turn rates between images: a camera in a hand turns faster and slower in between");
    s.number("neighbours", neighbours, "", {1, 100}, "keyframes before that one is matched to");
    s.number("others", others, "", {0, 100}, "earlier keyframes of the same view that one is matched to");
    s.number("view_distance", view_distance, "m", {0.01, 100}, "between keyframes of the same view");
    s.number("view_angle", view_angle, "rad", {0.01, 3.2}, "between keyframes of the same view");
    s.number("match_gate", match_gate, "pixels", {0.5, 1000},
             "that a match may miss the motion of the others by");
    s.number("landmarks", landmarks, "", {50, 1e6}, "at most, those seen most often");
    s.number("seed", seed, "", {0, 2147483647}, "of RANSAC");
  }
};

class RecordedScene {
 public:
  /// `start`: the calibration that the recording is understood by.
  RecordedScene(const RgbdCalibration& start, const RecordedSceneSettings& settings);
  ~RecordedScene();

  /// In the order of their stamps; decoded, of the calibration's sizes.
  void add(const RgbdFrame& frame);
  /// Wheels, say: the camera's velocity comes from them where they cover it and the camera is mounted. What
  /// is no later than the one before is left out, as frames are.
  void add(const MotionSample& odometry);
  /// Wheels came, and the calibration does not say where on the robot the camera sits.
  bool wheels_lack_mount() const { return wheels_came_ && !start_.has_mount; }

  /// Hz, least rate of images that tell a camera's velocity where wheels do not.
  static constexpr double slowest_images = 4;

  int frames() const { return frames_; }
  int tracked() const { return static_cast<int>(path_.size()); }
  /// With their images in memory, 1 MB each at 640x480: at most three times what observations() takes. A
  /// longer recording lets go of every second one, and of what comes later keeps as few.
  std::size_t kept_keyframes() const { return keyframes_.size(); }
  /// The camera's poses by visual odometry where it tracked, each with the colour image's stamp.
  struct PathPose {
    Utime utime;
    Eigen::Isometry3d T_world_camera;
  };
  const std::vector<PathPose>& path() const { return path_; }
  /// How the camera turned from image to image, for OdometryClock.
  const std::vector<CameraTurn::Step>& turns() const { return turns_; }

  /// Landmarks with the pixels of their features. Throws std::runtime_error when the recording shows too
  /// little.
  SceneObservations observations() const;

 private:
  struct Keyframe {
    std::size_t pose;  // in path_
    FeatureFrame features;
    ObservedKeyframe observed;  // but for what is computed when it is asked for
    cv::Mat depth;              // mm: half the size of its inverse
  };
  bool is_keyframe(const Eigen::Isometry3d& T) const;
  bool is_to_be_kept();
  struct Velocity {
    Vector6d twist;
    double turn_noise;
  };
  std::optional<Velocity> velocity_at(std::size_t pose) const;
  Vector6d motion_between(std::size_t pose, std::size_t later) const;
  double image_rate() const;
  std::string why_too_few(std::size_t keyframes, int without_velocity) const;
  std::vector<std::size_t> views_of(const std::vector<const Keyframe*>& keyframes, std::size_t of) const;

  RgbdCalibration start_;
  RecordedSceneSettings settings_;
  struct Detector;
  std::unique_ptr<Detector> detector_;
  VisualOdometry odometry_;
  std::vector<PathPose> path_;
  std::vector<Keyframe> keyframes_;
  std::optional<Eigen::Isometry3d> last_keyframe_;  // kept or not
  std::size_t keyframes_seen_ = 0, keep_each_ = 1;
  MotionBuffer wheels_;
  bool wheels_came_ = false;
  CameraTurn turn_;
  std::vector<CameraTurn::Step> turns_;
  int frames_ = 0;
};

}  // namespace lcmslam
