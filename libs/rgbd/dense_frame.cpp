#include <lcmslam/rgbd/dense_frame.hpp>

namespace lcmslam {

DenseFrame coloured_frame(Utime utime, const ColouredCloud& cloud, const Eigen::Isometry3d& T_robot_camera,
                          const std::optional<Motion>& motion) {
  DenseFrame frame;
  frame.utime = utime;
  frame.cloud = geometry_of(cloud);
  frame.colouriser = [cloud] { return cloud; };
  frame.T_robot_camera = T_robot_camera;
  frame.motion = motion;
  return frame;
}

}  // namespace lcmslam
