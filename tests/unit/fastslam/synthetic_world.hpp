#pragma once
// A small world whose truth is known exactly: landmarks with random descriptors on the walls and boxes
// of a room, a robot that drives laps in it, odometry with scale errors and slips, and a camera that
// sees points with noise, loses some, invents some, and mistakes some for others.

#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam::synthetic {

struct WorldSettings {
  int landmarks = 900;
  int frames = 440;
  double frame_seconds = 0.1;
  double detection = 0.6;         // probability that a visible landmark is found
  double wrong_match = 0.07;      // probability that a feature carries another landmark's descriptor
  double clutter = 0.1;           // invented features, as a fraction of the true ones
  double descriptor_noise = 0.2;  // length of the noise added to a unit descriptor
  double pixel_sigma = 1.0;       // px
  double depth_sigma = 0.012;     // m at 3 m and nearer, growing with the square beyond
  double wiggle = 0.006;          // m, systematic error of the range (time-of-flight), period 1.9 m
  double scale_error = 0.02, rotation_error = 0.03;
  bool slips = true;         // 2-5 cm and 1-3 degrees every 10 m
  double timing = 0;         // s, sigma of the moment at which a feature was seen, about its image's
  bool full_motion = false;  // the robot also heaves, rolls and pitches
  double ramp = 0;           // m that the floor rises across the room's middle
  double stated_translation = 0.003, stated_rotation = 0.002;  // sigma of a step that odometry claims
};

inline WorldSettings short_world(int frames) {
  WorldSettings world;
  world.frames = frames;
  return world;
}

struct Point {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;
  std::array<double, 64> descriptor;
  std::int8_t laplacian;
};

struct Step {
  Motion motion;
  FeatureFrame frame;
  Eigen::Isometry3d T_start_robot;     // truth, relative to the first robot pose
  Eigen::Isometry3d T_start_odometry;  // dead reckoning
  std::vector<int> truth;              // landmark of each feature, -1: invented or mistaken
};

inline std::array<double, 64> random_descriptor(Random& random) {
  std::array<double, 64> d;
  double sum = 0;
  for (double& v : d) {
    v = random.normal();
    sum += v * v;
  }
  for (double& v : d) v /= std::sqrt(sum);
  return d;
}

inline Descriptor noisy_bytes(const std::array<double, 64>& d, double noise, Random& random) {
  Descriptor bytes;
  for (std::size_t i = 0; i < 64; ++i)
    bytes[i] =
        static_cast<std::uint8_t>(std::clamp(128 + 127 * (d[i] + noise / 8 * random.normal()), 0.0, 255.0));
  return bytes;
}

inline std::vector<Point> make_points(const WorldSettings& s, Random& random) {
  std::vector<Point> points;
  for (int i = 0; i < s.landmarks; ++i) {
    Point p;
    const double along = random.uniform(-1, 1), height = random.uniform(0.1, 2.4);
    const double recess = random.below(2) == 0 ? 0 : 0.5;
    switch (random.below(5)) {  // a room of 6.4 x 5.2 m, centred; boxes of varying depth before its walls
      case 0:
        p.position << 3.2 - recess, 2.6 * along, height;
        p.normal << -1, 0, 0;
        break;
      case 1:
        p.position << -3.2, 2.6 * along, height;
        p.normal << 1, 0, 0;
        break;
      case 2:
        p.position << 3.2 * along, 2.6, height;
        p.normal << 0, -1, 0;
        break;
      case 3:
        p.position << 3.2 * along, -2.6 + recess, height;
        p.normal << 0, 1, 0;
        break;
      default:
        p.position << 3.2 * along, 2.6 * random.uniform(-1, 1), 0.02;
        p.normal << 0, 0, 1;
        break;
    }
    p.descriptor = random_descriptor(random);
    p.laplacian = random.below(2) == 0 ? -1 : 1;
    points.push_back(p);
  }
  return points;
}

/// Pose on the lap: an ellipse, heading along the tangent.
inline Eigen::Isometry3d true_pose(const WorldSettings& s, int frame) {
  const double t = 0.28 * s.frame_seconds * frame;
  Eigen::Isometry3d T =
      planar_pose(1.6 * std::cos(t), 1.2 * std::sin(t), std::atan2(1.2 * std::cos(t), -1.6 * std::sin(t)));
  if (s.ramp > 0) {  // at most 1.25 x ramp rad steep
    const double u = std::tanh(T.translation().x() / 0.4), slope = s.ramp * (1 - u * u) / 0.8;
    const Eigen::Vector3d up = Eigen::Vector3d(-slope, 0, 1).normalized(), forward = T.linear().col(0);
    const Eigen::Vector3d x = Eigen::Vector3d(forward.x(), forward.y(), slope * forward.x()).normalized();
    T.translation().z() = 0.5 * s.ramp * (1 + u);
    T.linear() << x, up.cross(x), up;
  }
  if (s.full_motion) {
    Vector6d sway;
    sway << 0, 0, 0.15 * std::sin(1.3 * t), 0.1 * std::sin(2.1 * t), 0.12 * std::sin(1.7 * t), 0;
    T = T * se3_exp(sway);
  }
  return T;
}

inline FeatureFrame see(const WorldSettings& s, const std::vector<Point>& points,
                        const Eigen::Isometry3d& T_world_robot, Random& random, std::vector<int>& truth,
                        const Vector6d& twist = Vector6d::Zero()) {
  FeatureFrame frame;
  frame.width = 640;
  frame.height = 480;
  frame.fx = frame.fy = 554;
  frame.cx = 320;
  frame.cy = 240;
  frame.pixel_sigma = s.pixel_sigma;
  frame.has_mount = true;
  frame.T_robot_camera = Eigen::Translation3d(0.1, 0, 1.3) *
                         Eigen::AngleAxisd(20 * M_PI / 180, Eigen::Vector3d::UnitY()) * optical_axes();
  const Eigen::Isometry3d T_camera_world = (T_world_robot * frame.T_robot_camera).inverse();
  truth.clear();
  const auto add = [&](const Eigen::Vector3d& p, const std::array<double, 64>& descriptor,
                       std::int8_t laplacian, int who) {
    const double range = p.norm();
    const double sigma = s.depth_sigma * std::max(1.0, range * range / 9);
    Feature f;
    f.x = static_cast<float>(frame.fx * p.x() / p.z() + frame.cx + s.pixel_sigma * random.normal());
    f.y = static_cast<float>(frame.fy * p.y() / p.z() + frame.cy + s.pixel_sigma * random.normal());
    f.response = static_cast<float>(random.uniform(1, 10));
    f.laplacian = laplacian;
    f.kind = MeasurementKind::point;
    const double wiggle = s.wiggle * std::sin(2 * M_PI * range / 1.9);
    const Eigen::Vector3d ray((f.x - frame.cx) / frame.fx, (f.y - frame.cy) / frame.fy, 1);
    f.point = ((range + wiggle + sigma * random.normal()) * ray.normalized()).cast<float>();
    f.depth_sigma = static_cast<float>(sigma);
    f.descriptor = noisy_bytes(descriptor, s.descriptor_noise, random);
    frame.features.push_back(f);
    truth.push_back(who);
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector3d p = T_camera_world * points[i].position;
    if (s.timing > 0) {
      const Eigen::Isometry3d T_later = se3_exp(Vector6d(s.timing * random.normal() * twist));
      p = frame.T_robot_camera.inverse() * T_later.inverse() * frame.T_robot_camera * p;
    }
    if (p.z() < 0.3 || p.norm() > 7.5) continue;
    if (std::abs(p.x() / p.z()) > 320 / 554.0 || std::abs(p.y() / p.z()) > 240 / 554.0) continue;
    if ((T_camera_world.linear() * points[i].normal).dot(-p.normalized()) < 0.25) continue;
    if (random.uniform() > s.detection) continue;
    if (random.uniform() < s.wrong_match) {
      const Point& other = points[random.below(points.size())];
      add(p, other.descriptor, other.laplacian, -1);
    } else {
      add(p, points[i].descriptor, points[i].laplacian, static_cast<int>(i));
    }
  }
  const auto invented = static_cast<int>(s.clutter * static_cast<double>(truth.size()));
  for (int i = 0; i < invented; ++i) {
    const double z = random.uniform(0.5, 6);
    add(Eigen::Vector3d(random.uniform(-0.5, 0.5) * z, random.uniform(-0.4, 0.4) * z, z),
        random_descriptor(random), random.below(2) == 0 ? -1 : 1, -1);
  }
  return frame;
}

struct Drive {
  std::vector<Point> points;
  std::vector<Step> steps;
};

inline Drive make_drive(const WorldSettings& s, std::uint64_t seed) {
  Random random(seed, 77);
  Drive drive;
  drive.points = make_points(s, random);
  const double scale = 1 + s.scale_error * (random.below(2) == 0 ? -1 : 1) * random.uniform(0.8, 1.2);
  const double rotation = 1 + s.rotation_error * (random.below(2) == 0 ? -1 : 1) * random.uniform(0.8, 1.2);
  const Eigen::Isometry3d T_start = true_pose(s, 0);
  Eigen::Isometry3d T_odometry = Eigen::Isometry3d::Identity();
  double until_slip = random.uniform(3, 10);
  for (int i = 0; i < s.frames; ++i) {
    Step step;
    const Eigen::Isometry3d T = true_pose(s, i);
    step.T_start_robot = T_start.inverse() * T;
    if (i > 0) {
      Vector6d twist = se3_log(true_pose(s, i - 1).inverse() * T);
      const double distance = twist.head<3>().norm();
      twist.head<3>() *= scale;
      twist.tail<3>() *= rotation;
      if (s.ramp > 0) twist.segment<3>(2).setZero();  // wheels know nothing of it
      const int free = s.full_motion ? 6 : 3;
      for (int c = 0; c < 6; ++c)
        if (free == 6 || c < 2 || c == 5)
          twist(c) += (c < 3 ? 0.1 * distance * 0.1 : 0.002 * std::sqrt(distance)) * random.normal();
      until_slip -= distance;
      if (s.slips && until_slip < 0) {
        until_slip = random.uniform(8, 12);
        const double direction = random.uniform(0, 2 * M_PI), slip = random.uniform(0.02, 0.05);
        twist(0) += slip * std::cos(direction);
        twist(1) += slip * std::sin(direction);
        twist(5) += (random.below(2) == 0 ? -1 : 1) * random.uniform(1, 3) * M_PI / 180;
      }
      step.motion.T_from_to = se3_exp(twist);
      step.motion.covariance.diagonal().head<3>().setConstant(s.stated_translation * s.stated_translation);
      step.motion.covariance.diagonal().tail<3>().setConstant(s.stated_rotation * s.stated_rotation);
      T_odometry = T_odometry * step.motion.T_from_to;
    }
    step.T_start_odometry = T_odometry;
    const Vector6d twist = se3_log(T.inverse() * true_pose(s, i + 1)) / s.frame_seconds;
    step.frame = see(s, drive.points, T, random, step.truth, twist);
    step.frame.utime = 1'000'000 + static_cast<Utime>(i) * 100'000;
    step.frame.seq = i;
    drive.steps.push_back(std::move(step));
  }
  return drive;
}

}  // namespace lcmslam::synthetic
