#pragma once
// What a recording shows of a head: keyframes with their depth images, and landmarks seen in several.

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct ObservedKeyframe {
  Utime utime = 0;                                                   ///< of the colour image
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();  ///< at the middle of the colour image
  Vector6d twist = Vector6d::Zero();  ///< of the camera, its own frame: m/s, rad/s
  double turn_noise = 0;              ///< rad/s, standard deviation of the twist's turn rate on each axis
  std::optional<Vector6d> motion;  ///< log of T_previous_this by what said the twist: as twist times seconds
  double depth_lag = 0;            ///< s from the colour image's stamp to the depth image's, as stamped
  cv::Mat inverse_depth;           ///< CV_32FC1, 1/m along the optical axis, 0 = none
  cv::Mat grey;  ///< CV_8UC1, the colour image, smoothed by as much as makes its values between pixels agree
};

struct LandmarkSighting {
  int keyframe = 0;
  Eigen::Vector2d pixel;  ///< in the colour image as it came, distortion included
  double sigma = 1;       ///< pixels, but for a common factor
};

struct SightedLandmark {
  Eigen::Vector3d point;  ///< world
  std::vector<LandmarkSighting> sightings;
};

struct SceneObservations {
  std::vector<ObservedKeyframe> keyframes;
  std::vector<SightedLandmark> landmarks;
};

}  // namespace lcmslam
