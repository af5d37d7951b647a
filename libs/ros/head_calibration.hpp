#pragma once
// The calibration of a camera head by what a recording says: CameraInfo of both cameras, transforms between
// their frames and the robot's.

#include <optional>
#include <string>
#include <vector>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/ros/topic_choice.hpp>
#include <lcmslam/ros/transform_tree.hpp>

namespace lcmslam::ros {

/// One camera as the recording has it.
struct RecordedCamera {
  std::string topic;  ///< of its images
  std::string frame;  ///< of its images; empty: they do not say
  PixelCount size;    ///< of its images
  std::optional<CameraInfo> info;
  std::string info_topic;
};

struct HeadCalibration {
  RgbdCalibration calibration;
  std::string robot_frame;  ///< of the mount; empty where none is known
  std::vector<std::string> notes;
};

/// `robot_frames`: which are the robot's, the first that leads to the camera is taken. Depth is registered to
/// colour when both images are of one frame, or its topic says so and tf does not say otherwise, and their
/// cameras are alike. Throws DatasetError when the intrinsics or the transform between the cameras are not
/// there: it says what would help.
HeadCalibration make_calibration(const RecordedCamera& colour, const RecordedCamera& depth,
                                 const TransformTree& transforms,
                                 const std::vector<std::string>& robot_frames);

}  // namespace lcmslam::ros
