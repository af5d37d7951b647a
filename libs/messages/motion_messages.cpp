#include <lcmslam/messages/motion_messages.hpp>

#include <algorithm>
#include <limits>

#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {

encoders_t to_message(const Encoders& encoders) {
  encoders_t m{};
  m.utime = encoders.utime;
  m.n_wheels = static_cast<int32_t>(encoders.wheels.size());
  for (const Wheel& w : encoders.wheels) {
    wheel_t wheel;
    wheel.x = w.x;
    wheel.y = w.y;
    wheel.radius = w.radius;
    wheel.roller_angle = w.roller_angle;
    wheel.angle = w.angle;
    wheel.steering = w.steering;
    m.wheels.push_back(wheel);
  }
  return m;
}

Encoders from_message(const encoders_t& m) {
  check_range(m.n_wheels, 2, 64, "n_wheels");
  Encoders encoders{m.utime, m.seq, m.sender, {}};
  for (const wheel_t& w : m.wheels) {
    check_range(w.x, -100, 100, "wheel x");
    check_range(w.y, -100, 100, "wheel y");
    check_range(w.radius, 1e-4, 100, "wheel radius");
    check_range(w.roller_angle, -1.5, 1.5, "wheel roller_angle");
    check_range(w.angle, -1e9, 1e9, "wheel angle");
    check_range(w.steering, -1e4, 1e4, "wheel steering");
    encoders.wheels.push_back({w.x, w.y, w.radius, w.roller_angle, w.angle, w.steering});
  }
  return encoders;
}

twist_t to_message(const Twist& twist) {
  twist_t m{};
  m.utime = twist.utime;
  for (int i = 0; i < 3; ++i) {
    m.linear[i] = twist.linear(i);
    m.angular[i] = twist.angular(i);
  }
  return m;
}

Twist from_message(const twist_t& m) {
  Twist twist;
  twist.utime = m.utime;
  for (int i = 0; i < 3; ++i) {
    check_range(m.linear[i], -1e3, 1e3, "linear");
    check_range(m.angular[i], -1e3, 1e3, "angular");
    twist.linear(i) = m.linear[i];
    twist.angular(i) = m.angular[i];
  }
  return twist;
}

odometry_t to_message(const MotionSample& sample, const std::string& source) {
  odometry_t m{};
  m.utime = sample.utime;
  m.frame = "odom";
  m.child_frame = "robot";
  m.source = source;
  m.T_odom_robot = to_message(sample.T_odom_robot);
  to_message(sample.covariance, m.covariance);
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::fill_n(m.linear_velocity, 3, unknown);
  std::fill_n(m.angular_velocity, 3, unknown);
  std::fill_n(m.velocity_covariance, 36, unknown);
  m.status = pose_estimate_t::TRACKING;
  m.quality = 1;
  return m;
}

MotionSample from_message(const odometry_t& m) {
  MotionSample sample;
  sample.utime = m.utime;
  sample.T_odom_robot = from_message(m.T_odom_robot, "T_odom_robot");
  sample.covariance = covariance_from_message(m.covariance, "covariance");
  sample.visual = m.source == "visual";
  return sample;
}

pose_estimate_t make_pose_estimate(Utime utime, const Eigen::Isometry3d& T_map_robot,
                                   const Matrix6d& covariance) {
  pose_estimate_t m{};
  m.utime = utime;
  m.frame = "map";
  m.child_frame = "robot";
  m.T_map_robot = to_message(T_map_robot);
  to_message(covariance, m.covariance);
  m.status = pose_estimate_t::TRACKING;
  m.quality = 1;
  m.inliers = 0;
  m.map_revision = 0;
  m.processing_time = 0;
  return m;
}

}  // namespace lcmslam
