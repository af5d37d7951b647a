#pragma once
// What lcmslam reads of ROS's messages. Images point into the bytes that they were read from.

#include <array>
#include <string>
#include <vector>

#include <lcmslam/ros/message_bytes.hpp>

namespace lcmslam::ros {

/// sensor_msgs/Image, and CompressedImage, whose size and step stay 0.
struct Image {
  RosHeader header;
  std::uint32_t width = 0, height = 0, step = 0;
  std::string encoding;  ///< "rgb8"; of a CompressedImage its format: "jpeg", "16UC1; compressedDepth png"
  bool compressed = false;
  bool big_endian = false;
  ByteView data;
};

/// sensor_msgs/CameraInfo.
struct CameraInfo {
  RosHeader header;
  std::uint32_t width = 0, height = 0;
  std::string distortion_model;
  std::vector<double> D;
  std::array<double, 9> K{};
  std::array<double, 12> P{};
  std::uint32_t binning_x = 0, binning_y = 0;
  std::uint32_t roi_width = 0, roi_height = 0;
};

/// nav_msgs/Odometry; geometry_msgs/PoseStamped and PoseWithCovarianceStamped have neither child nor
/// velocity.
struct Pose {
  RosHeader header;
  std::string child_frame;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< of the child in the header's frame
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();        ///< m/s, in the child's frame
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();       ///< rad/s
};

/// One of a tf2_msgs/TFMessage.
struct Transform {
  RosHeader header;  ///< the parent's frame
  std::string child_frame;
  Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
};

/// tf2_msgs/TFMessage.
struct Transforms {
  std::vector<Transform> usable;
  std::vector<std::string>
      unusable;  ///< "from base to gripper": not finite, or the quaternion is no unit one
};

/// "sensor_msgs/msg/Image" as "sensor_msgs/Image".
std::string short_type(std::string type);

bool is_image(const std::string& type);  ///< by its short name; so are the rest
bool is_camera_info(const std::string& type);
bool is_odometry(const std::string& type);
bool is_pose(const std::string& type);  ///< odometry too
bool is_transforms(const std::string& type);
bool is_number(const std::string& type);  ///< std_msgs/Float64

/// Each throws RecordingError when the bytes are no message of that type.
Image read_image(ByteView message, const std::string& type, const std::string& encoding);
CameraInfo read_camera_info(ByteView message, const std::string& encoding);
Pose read_pose(ByteView message, const std::string& type, const std::string& encoding);
Transforms read_transforms(ByteView message, const std::string& encoding);
double read_number(ByteView message, const std::string& encoding);

}  // namespace lcmslam::ros
