#include <lcmslam/ros/definitions.hpp>

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace lcmslam::ros {
namespace {

struct Definition {
  const char* type;  // as definitions name it
  const char* fields;
};

constexpr Definition definitions[] = {
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"std_msgs/Float64", "float64 data\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/PoseWithCovarianceStamped",
     "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"sensor_msgs/Image",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n"
     "uint8[] data\n"},
    {"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
    {"sensor_msgs/RegionOfInterest",
     "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"},
    {"sensor_msgs/CameraInfo",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] "
     "k\n"
     "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n"},
    {"sensor_msgs/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
    {"sensor_msgs/PointCloud2",
     "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool "
     "is_bigendian\n"
     "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
};

const char* fields_of(const std::string& type) {
  const auto* end = std::end(definitions);
  const auto* found =
      std::find_if(std::begin(definitions), end, [&](auto& known) { return type == known.type; });
  if (found == end) throw std::invalid_argument(type + ": lcmslam writes no such ROS message");
  return found->fields;
}

/// The types that are members, each before its own members.
void add_members(const std::string& type, std::vector<std::string>& types) {
  std::istringstream lines(fields_of(type));
  for (std::string member, name; lines >> member >> name;) {
    member = member.substr(0, member.find('['));
    if (member.find('/') == std::string::npos) continue;
    if (std::find(types.begin(), types.end(), member) == types.end()) types.push_back(member);
    add_members(member, types);
  }
}

}  // namespace

std::string message_definition(const std::string& type) {
  std::string whole = type;
  if (const std::size_t middle = whole.find("/msg/"); middle != std::string::npos) whole.erase(middle, 4);
  std::vector<std::string> members;
  add_members(whole, members);
  std::string text = fields_of(whole);
  for (const std::string& member : members)
    text += std::string(80, '=') + "\nMSG: " + member + "\n" + fields_of(member);
  return text;
}

}  // namespace lcmslam::ros
