#pragma once
// Messages of ROS 2 as bytes (CDR).

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/ros/messages.hpp>

namespace lcmslam::ros {

CdrWriter write_compressed_image(const RosHeader& header, const std::string& format, ByteView image);
/// CV_16UC1 as "16UC1", CV_8UC1 as "mono8", CV_8UC3 as "bgr8".
CdrWriter write_image(const RosHeader& header, const cv::Mat& image);
CdrWriter write_camera_info(const RosHeader& header, const CameraModel& camera);
CdrWriter write_pose(const RosHeader& header, const Eigen::Isometry3d& pose);

/// Covariances are lcmslam's (of T exp(xi): translation, rotation, in the body's frame); written are ROS's,
/// whose axes are those of the header's frame.
CdrWriter write_pose_with_covariance(const RosHeader& header, const Eigen::Isometry3d& pose,
                                     const Matrix6d& covariance);
/// Velocities that are not finite are not known: 0, with -1 as the first variance.
CdrWriter write_odometry(const RosHeader& header, const std::string& child_frame,
                         const Eigen::Isometry3d& pose, const Matrix6d& covariance,
                         const Eigen::Vector3d& linear, const Eigen::Vector3d& angular,
                         const Matrix6d& velocity_covariance);
CdrWriter write_number(double number);
CdrWriter write_transforms(const std::vector<Transform>& transforms);

struct ColouredPoint {
  Eigen::Vector3f position;  ///< m, in the header's frame
  std::uint8_t r = 0, g = 0, b = 0;
};
CdrWriter write_points(const RosHeader& header, const std::vector<ColouredPoint>& points);

/// A covariance of T exp(xi) with xi in the body's frame, with xi about the axes of the frame that T is given
/// in.
Matrix6d covariance_in_parent(const Eigen::Isometry3d& T, const Matrix6d& covariance);

}  // namespace lcmslam::ros
