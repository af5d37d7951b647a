#pragma once
// What a map file holds beside keyframes and landmarks.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/map_store/dense_map.hpp>

namespace lcmslam {

/// Where a session lies. A mapper that begins beside an old map does not know where it is in that.
enum class SessionState {
  own_frame = 0,  ///< in a frame of its own
  joined = 1      ///< its place in the map's first frame is known: T_map_session
};

/// What one mapper made under one frame while one map server ran.
struct StoredSession {
  std::int64_t id = 0;      ///< in this file, from 1 in the order in which they began; 0: not in a file yet
  std::string mapper;       ///< "fastslam" or "icp"
  std::int64_t sender = 0;  ///< the process's, see status_t
  std::string frame;        ///< as its messages named it
  SessionState state = SessionState::own_frame;
  std::optional<Eigen::Isometry3d> T_map_session = std::nullopt;
  std::string evidence = {};  ///< what says where it lies, in words
};

/// One process that wrote into the file.
struct StoredRun {
  std::string version;        ///< lcmslam's
  std::string configuration;  ///< YAML
};

struct StoredEdge {
  std::int32_t from = 0, to = 0;                                ///< ids of keyframes
  int kind = 0;                                                 ///< graph_edge_t's
  Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();  ///< measured, camera frames
  float sigma_translation = 0;                                  ///< m
  float sigma_rotation = 0;                                     ///< rad
  float error = 0;                                              ///< Mahalanobis distance after optimisation
};

struct StoredPose {
  Utime utime = 0;
  Eigen::Isometry3d T_map_robot = Eigen::Isometry3d::Identity();
};

/// A node of the graph. Its cloud, where it has one, and its features are stored apart: poses move often.
struct StoredKeyframe {
  std::int32_t id = 0;
  Utime utime = 0;
  Eigen::Isometry3d T_map_camera = Eigen::Isometry3d::Identity();
  std::optional<Matrix6d> covariance = std::nullopt;  ///< as pose_estimate_t's of ICP_POSE
};

struct StoredCalibration {
  std::string sensor;
  std::string form;                 ///< what the bytes are: "camera_calibration_t"
  std::vector<std::uint8_t> bytes;  ///< as the writer's messages have them
};

/// The camera's images of a keyframe as they travelled, so that all that is derived can be made anew.
struct StoredImages {
  EncodedFrame frame;  ///< without amplitude
  /// From where the colour camera was at the depth image's time to where it was at its own.
  Eigen::Isometry3d T_colour_depth_time = Eigen::Isometry3d::Identity();
  /// What held when they were taken; a sensor's may be another one later. Null: nobody knows; when they are
  /// written, what was told last of their sensor.
  std::shared_ptr<const StoredCalibration> calibration = nullptr;
};

}  // namespace lcmslam
