#pragma once
// Which topics of a recording are the camera head and the odometry.

#include <cstdint>
#include <string>
#include <vector>

#include <lcmslam/ros/images.hpp>

namespace lcmslam::ros {

/// What is known of a topic when the recording was looked through once.
struct TopicFacts {
  std::string name;
  std::string type;  ///< short
  std::int64_t messages = 0;
  // Of the first image or pose:
  ImageKind kind = ImageKind::unknown;
  std::string encoding;
  PixelCount size;
  std::string frame;  ///< in which it is measured; of Odometry its child's
};

/// Names; empty: to be chosen, or none there.
struct Topics {
  std::string colour, depth;
  std::string colour_info, depth_info;  ///< CameraInfo
  std::string odometry;
  std::string truth;  ///< true poses, for evaluation only
};

struct TopicChoice {
  Topics topics;
  std::vector<std::string> notes;  ///< a line for each: what was chosen, and from what else
};

/// Takes what is wanted, and chooses the rest by types, encodings and names; of equals the one with more
/// messages. Of several cameras' depth images those are taken that are of colour's frame, else whose name
/// begins as colour's does. Throws DatasetError when a wanted topic is not there or of another type, or when
/// there are no colour or no depth images: it says which topics there are.
TopicChoice choose_topics(const std::vector<TopicFacts>& topics, const Topics& wanted);

/// "/camera/color/image_raw/compressed" -> "/camera/color/camera_info"
std::string camera_info_beside(const std::string& image_topic);
/// "/camera/depth/image" -> "/camera/depth/clock_offset": seconds that our export has added to depth's stamps
/// (std_msgs/Float64), in force from its message on.
std::string clock_offset_beside(const std::string& image_topic);

}  // namespace lcmslam::ros
