#include <lcmslam/ros/message_writers.hpp>

#include <stdexcept>

namespace lcmslam::ros {
namespace {

void write_covariance(CdrWriter& writer, const Matrix6d& covariance) {
  for (int row = 0; row < 6; ++row)
    for (int column = 0; column < 6; ++column) writer.number(covariance(row, column));
}

void write_vector(CdrWriter& writer, const Eigen::Vector3d& vector) {
  writer.numbers(vector.data(), 3);
}

}  // namespace

Matrix6d covariance_in_parent(const Eigen::Isometry3d& T, const Matrix6d& covariance) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T.linear();
  return turn * covariance * turn.transpose();
}

CdrWriter write_compressed_image(const RosHeader& header, const std::string& format, ByteView image) {
  CdrWriter writer;
  writer.header(header);
  writer.text(format);
  writer.bytes(image);
  return writer;
}

CdrWriter write_image(const RosHeader& header, const cv::Mat& image) {
  const char* encoding = image.type() == CV_16UC1  ? "16UC1"
                         : image.type() == CV_8UC1 ? "mono8"
                         : image.type() == CV_8UC3 ? "bgr8"
                                                   : nullptr;
  if (encoding == nullptr) throw std::invalid_argument("write_image: must be CV_16UC1, CV_8UC1 or CV_8UC3");
  const cv::Mat rows = image.isContinuous() ? image : image.clone();
  const std::size_t step = static_cast<std::size_t>(rows.cols) * rows.elemSize();
  CdrWriter writer;
  writer.header(header);
  writer.number(static_cast<std::uint32_t>(rows.rows));
  writer.number(static_cast<std::uint32_t>(rows.cols));
  writer.text(encoding);
  writer.number(std::uint8_t{0});  // little-endian
  writer.number(static_cast<std::uint32_t>(step));
  writer.bytes({rows.data, step * static_cast<std::size_t>(rows.rows)});
  return writer;
}

CdrWriter write_camera_info(const RosHeader& header, const CameraModel& camera) {
  std::vector<double> d = camera.distortion;
  if (d.size() < 5) d.resize(5);  // ROS's plumb_bob
  const double k[] = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  const double r[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double p[] = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  CdrWriter writer;
  writer.header(header);
  writer.number(static_cast<std::uint32_t>(camera.height));
  writer.number(static_cast<std::uint32_t>(camera.width));
  writer.text(d.size() == 5 ? "plumb_bob" : "rational_polynomial");
  writer.count(d.size());
  writer.numbers(d.data(), d.size());
  writer.numbers(k, 9);
  writer.numbers(r, 9);
  writer.numbers(p, 12);
  for (int i = 0; i < 6; ++i)
    writer.number(std::uint32_t{0});  // binning, region of interest: the whole image
  writer.number(std::uint8_t{0});
  return writer;
}

CdrWriter write_number(double number) {
  CdrWriter writer;
  writer.number(number);
  return writer;
}

CdrWriter write_pose(const RosHeader& header, const Eigen::Isometry3d& pose) {
  CdrWriter writer;
  writer.header(header);
  writer.pose(pose);
  return writer;
}

CdrWriter write_pose_with_covariance(const RosHeader& header, const Eigen::Isometry3d& pose,
                                     const Matrix6d& covariance) {
  CdrWriter writer = write_pose(header, pose);
  write_covariance(writer, covariance_in_parent(pose, covariance));
  return writer;
}

CdrWriter write_odometry(const RosHeader& header, const std::string& child_frame,
                         const Eigen::Isometry3d& pose, const Matrix6d& covariance,
                         const Eigen::Vector3d& linear, const Eigen::Vector3d& angular,
                         const Matrix6d& velocity_covariance) {
  const bool is_known = linear.allFinite() && angular.allFinite();
  Matrix6d of_velocity = velocity_covariance;
  if (!is_known) {
    of_velocity.setZero();
    of_velocity(0, 0) = -1;
  }
  CdrWriter writer;
  writer.header(header);
  writer.text(child_frame);
  writer.pose(pose);
  write_covariance(writer, covariance_in_parent(pose, covariance));
  write_vector(writer, is_known ? linear : Eigen::Vector3d::Zero());
  write_vector(writer, is_known ? angular : Eigen::Vector3d::Zero());
  write_covariance(writer, of_velocity);
  return writer;
}

CdrWriter write_transforms(const std::vector<Transform>& transforms) {
  CdrWriter writer;
  writer.count(transforms.size());
  for (const Transform& transform : transforms) {
    writer.header(transform.header);
    writer.text(transform.child_frame);
    writer.pose(transform.T_parent_child);
  }
  return writer;
}

CdrWriter write_points(const RosHeader& header, const std::vector<ColouredPoint>& points) {
  constexpr std::uint32_t point_size = 16;
  constexpr std::uint8_t float32 = 7;
  CdrWriter writer;
  writer.header(header);
  writer.number(std::uint32_t{1});
  writer.number(static_cast<std::uint32_t>(points.size()));
  writer.count(4);
  std::uint32_t offset = 0;
  for (const char* name : {"x", "y", "z", "rgb"}) {
    writer.text(name);
    writer.number(offset);
    writer.number(float32);
    writer.number(std::uint32_t{1});
    offset += 4;
  }
  writer.number(std::uint8_t{0});  // little-endian
  writer.number(point_size);
  writer.number(static_cast<std::uint32_t>(points.size()) * point_size);
  ByteWriter bytes;
  for (const ColouredPoint& point : points) {
    for (int i = 0; i < 3; ++i) bytes.number(point.position(i));
    bytes.number(std::uint32_t{point.r} << 16 | std::uint32_t{point.g} << 8 | std::uint32_t{point.b});
  }
  writer.bytes(bytes.view());
  writer.number(std::uint8_t{1});  // no point is NaN
  return writer;
}

}  // namespace lcmslam::ros
