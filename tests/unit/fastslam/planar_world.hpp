#pragma once
// A planar world of beacons with known identities: a robot drives laps among them, measures range and
// bearing (or offsets), and its odometry errs systematically as well as at random.

#include <cmath>
#include <vector>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam::synthetic {

struct PlanarWorldSettings {
  int beacons = 12;
  int frames = 600;
  double range_sigma = 0.05, bearing_sigma = 0.02;
  double range_offset = 0, range_scale = 0, bearing_offset = 0;  // of the sensor (sensor_calibration.hpp)
  double correlation = 0;  // of the range's error of one beacon from frame to frame
  double translation_sigma = 0.004, rotation_sigma = 0.004;  // of a step, as odometry states them
  double heading_per_m = 0;                                  // rad; systematic, and not stated
  double wrong_identity = 0;  // probability that an observation carries another beacon's identity
  double maximum_range = 6;
  bool offsets = false;  // planar offsets with range_sigma on each axis instead of range and bearing
};

struct PlanarStep {
  Motion motion;
  FeatureFrame frame;
  Eigen::Isometry3d T_start_robot;  // truth
};

struct PlanarDrive {
  std::vector<Eigen::Vector2d> beacons;  // in the frame of the first pose; identity = index
  std::vector<PlanarStep> steps;
};

inline PlanarDrive make_planar_drive(const PlanarWorldSettings& s, std::uint64_t seed) {
  Random random(seed, 99);
  const auto true_pose = [](int i) {
    const double t = 0.03 * i;  // a lap in 210 frames, on an ellipse
    return planar_pose(4 * std::cos(t), 3 * std::sin(t), std::atan2(3 * std::cos(t), -4 * std::sin(t)));
  };
  const Eigen::Isometry3d T_start = true_pose(0);
  PlanarDrive drive;
  std::vector<double> range_error(static_cast<std::size_t>(s.beacons));
  for (int b = 0; b < s.beacons; ++b) {
    const Eigen::Vector3d p(random.uniform(-7, 7), random.uniform(-6, 6), 0);
    drive.beacons.emplace_back((T_start.inverse() * p).head<2>());
    range_error[static_cast<std::size_t>(b)] = s.range_sigma * random.normal();
  }
  for (int i = 0; i < s.frames; ++i) {
    PlanarStep step;
    step.T_start_robot = T_start.inverse() * true_pose(i);
    if (i > 0) {
      Vector6d twist = se3_log(true_pose(i - 1).inverse() * true_pose(i));
      twist(5) += s.heading_per_m * twist.head<3>().norm();
      twist(0) += s.translation_sigma * random.normal();
      twist(1) += s.translation_sigma * random.normal();
      twist(5) += s.rotation_sigma * random.normal();
      step.motion.T_from_to = se3_exp(twist);
      step.motion.covariance.diagonal() << 1, 1, 1e-2, 0, 0, 0;
      step.motion.covariance *= s.translation_sigma * s.translation_sigma;
      step.motion.covariance.diagonal().tail<3>() << 1e-8, 1e-8, s.rotation_sigma * s.rotation_sigma;
    }
    step.frame.utime = 1'000'000 + static_cast<Utime>(i) * 200'000;
    step.frame.width = step.frame.height = 1;
    step.frame.fx = step.frame.fy = 1;
    step.frame.pixel_sigma = s.bearing_sigma;
    step.frame.has_mount = true;
    for (int b = 0; b < s.beacons; ++b) {
      auto& error = range_error[static_cast<std::size_t>(b)];
      error = s.correlation * error +
              std::sqrt(1 - s.correlation * s.correlation) * s.range_sigma * random.normal();
      const Eigen::Vector2d& beacon = drive.beacons[static_cast<std::size_t>(b)];
      const Eigen::Vector3d p = step.T_start_robot.inverse() * Eigen::Vector3d(beacon.x(), beacon.y(), 0);
      const double range = p.norm(), bearing = std::atan2(p.y(), p.x());
      if (range > s.maximum_range || range < 0.3 || std::abs(bearing) > 1.2) continue;
      Feature f;
      f.landmark_id = b;
      if (random.uniform() < s.wrong_identity)
        f.landmark_id = static_cast<int>(random.below(static_cast<std::uint64_t>(s.beacons)));
      f.depth_sigma = static_cast<float>(s.range_sigma);
      if (s.offsets) {
        f.kind = MeasurementKind::planar;
        f.point = Eigen::Vector3d(p.x() + error, p.y() + s.range_sigma * random.normal(), 0).cast<float>();
      } else {
        f.kind = MeasurementKind::range_bearing;
        f.point = Eigen::Vector3d(s.range_offset + (1 + s.range_scale) * range + error,
                                  s.bearing_offset + bearing + s.bearing_sigma * random.normal(), 0)
                      .cast<float>();
      }
      step.frame.features.push_back(f);
    }
    drive.steps.push_back(std::move(step));
  }
  return drive;
}

}  // namespace lcmslam::synthetic
