#pragma once
#include <string>

namespace lcmslam::ros {

/// The definition of a type of ROS 2 ("sensor_msgs/msg/Image") with those of all types in it, as MCAP's
/// "ros2msg" schemas want them. Throws std::invalid_argument for a type that lcmslam does not write.
std::string message_definition(const std::string& type);

}  // namespace lcmslam::ros
