#include <lcmslam/ros/messages.hpp>

namespace lcmslam::ros {

std::string short_type(std::string type) {
  if (const std::size_t middle = type.find("/msg/"); middle != std::string::npos) type.erase(middle, 4);
  return type;
}

bool is_image(const std::string& type) {
  return type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage";
}
bool is_camera_info(const std::string& type) {
  return type == "sensor_msgs/CameraInfo";
}
bool is_odometry(const std::string& type) {
  return type == "nav_msgs/Odometry";
}
bool is_pose(const std::string& type) {
  return is_odometry(type) || type == "geometry_msgs/PoseStamped" ||
         type == "geometry_msgs/PoseWithCovarianceStamped";
}
bool is_transforms(const std::string& type) {
  return type == "tf2_msgs/TFMessage" || type == "tf/tfMessage";
}
bool is_number(const std::string& type) {
  return type == "std_msgs/Float64";
}

Image read_image(ByteView message, const std::string& type, const std::string& encoding) {
  RosReader reader(message, encoding);
  Image image;
  image.header = reader.header();
  image.compressed = type == "sensor_msgs/CompressedImage";
  if (!image.compressed) {
    image.height = reader.number<std::uint32_t>();
    image.width = reader.number<std::uint32_t>();
  }
  image.encoding = reader.text();
  if (!image.compressed) {
    image.big_endian = reader.number<std::uint8_t>() != 0;
    image.step = reader.number<std::uint32_t>();
  }
  image.data = reader.bytes();
  reader.finish();
  return image;
}

CameraInfo read_camera_info(ByteView message, const std::string& encoding) {
  RosReader reader(message, encoding);
  CameraInfo info;
  info.header = reader.header();
  info.height = reader.number<std::uint32_t>();
  info.width = reader.number<std::uint32_t>();
  info.distortion_model = reader.text();
  info.D = reader.doubles();
  info.K = reader.doubles<9>();
  reader.doubles<9>();  // R, of stereo cameras
  info.P = reader.doubles<12>();
  info.binning_x = reader.number<std::uint32_t>();
  info.binning_y = reader.number<std::uint32_t>();
  reader.number<std::uint32_t>();  // the region's place
  reader.number<std::uint32_t>();
  info.roi_height = reader.number<std::uint32_t>();
  info.roi_width = reader.number<std::uint32_t>();
  reader.number<std::uint8_t>();  // whether it was rectified
  reader.finish();
  return info;
}

Pose read_pose(ByteView message, const std::string& type, const std::string& encoding) {
  RosReader reader(message, encoding);
  Pose pose;
  pose.header = reader.header();
  if (is_odometry(type)) {
    pose.child_frame = reader.frame();
  }
  pose.pose = reader.pose();
  if (type != "geometry_msgs/PoseStamped") reader.doubles<36>();
  if (is_odometry(type)) {
    pose.linear = reader.vector();
    pose.angular = reader.vector();
    reader.doubles<36>();
  }
  reader.finish();
  return pose;
}

Transforms read_transforms(ByteView message, const std::string& encoding) {
  RosReader reader(message, encoding);
  Transforms transforms;
  for (std::uint32_t left = reader.count(); left > 0; --left) {
    Transform transform;
    transform.header = reader.header();
    transform.child_frame = reader.frame();
    // /tf_static is one message of all: a gripper's broken transform must not take the camera's away.
    if (const auto pose = reader.pose_or_nothing()) {
      transform.T_parent_child = *pose;
      transforms.usable.push_back(std::move(transform));
    } else {
      transforms.unusable.push_back("from " + transform.header.frame + " to " + transform.child_frame);
    }
  }
  reader.finish();
  return transforms;
}

double read_number(ByteView message, const std::string& encoding) {
  RosReader reader(message, encoding);
  const auto number = reader.number<double>();
  reader.finish();
  return number;
}

}  // namespace lcmslam::ros
