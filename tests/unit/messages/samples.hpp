#pragma once
// Domain values with every member set to something that is not its default.

#include <cmath>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/odometry/encoders.hpp>

namespace lcmslam::testing {

inline Eigen::Isometry3d some_pose(Random& random) {
  Vector6d twist;
  for (int i = 0; i < 6; ++i) twist(i) = random.uniform(-1, 1);
  return se3_exp(twist);
}

inline Matrix6d some_covariance(Random& random) {
  Matrix6d root;
  for (int i = 0; i < 36; ++i) root(i) = random.normal();
  return root * root.transpose();
}

/// A frame of three images that decode.
inline EncodedFrame some_frame(Random& random, int width = 16, int height = 12) {
  RgbdFrame frame;
  frame.utime = 1'234'567;
  frame.depth_utime = 1'230'000;
  frame.sensor = "head";
  frame.colour.create(height, width, CV_8UC3);
  frame.depth.create(height / 2, width / 2, CV_16UC1);
  frame.amplitude.create(height / 2, width / 2, CV_8UC1);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      for (int k = 0; k < 3; ++k)
        frame.colour.at<cv::Vec3b>(v, u)[k] = static_cast<std::uint8_t>(random.below(256));
  for (int v = 0; v < height / 2; ++v)
    for (int u = 0; u < width / 2; ++u) {
      frame.depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(random.below(8000));
      frame.amplitude.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(random.below(256));
    }
  EncodedFrame encoded = encode(frame);
  encoded.sensor = frame.sensor;
  return encoded;
}

inline CameraModel some_camera(int width, int height) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 1.1 * width;
  camera.fy = 1.2 * width;
  camera.cx = 0.49 * width;
  camera.cy = 0.51 * height;
  camera.distortion = {0.05, -0.02, 0.001, -0.002, 0.003};
  return camera;
}

inline RgbdCalibration some_calibration(Random& random) {
  RgbdCalibration c;
  c.sensor = "head";
  c.colour = some_camera(16, 12);
  c.depth = some_camera(8, 6);
  c.depth.distortion = {};
  c.T_colour_depth = se3_exp((Vector6d() << 0.08, 0.01, -0.02, 0.03, 0.02, 0.01).finished());
  c.has_mount = true;
  c.T_robot_camera = some_pose(random);
  c.depth_clock_offset = -0.012;
  c.depth_noise = {0.001, 0.002, 0.3, 0.0007};
  c.depth_min = 0.35;
  c.depth_max = 7.5;
  c.pixel_sigma = 0.7;
  return c;
}

inline Encoders some_encoders(Random& random, std::size_t wheels = 4) {
  Encoders encoders;
  encoders.utime = 5'000'000;
  for (std::size_t i = 0; i < wheels; ++i)
    encoders.wheels.push_back({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.05, 0.2),
                               random.uniform(-0.8, 0.8), random.uniform(-100, 100), random.uniform(-3, 3)});
  return encoders;
}

inline Descriptor some_descriptor(Random& random) {
  Descriptor descriptor;
  for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(random.below(256));
  return descriptor;
}

inline Feature some_feature(Random& random) {
  Feature f;
  f.x = static_cast<float>(random.uniform(0, 640));
  f.y = static_cast<float>(random.uniform(0, 480));
  f.size = static_cast<float>(random.uniform(5, 50));
  f.angle = static_cast<float>(random.uniform(0, 6));
  f.response = static_cast<float>(random.uniform(0, 1000));
  f.laplacian = random.below(2) != 0 ? 1 : -1;
  f.octave = static_cast<std::int8_t>(random.below(4));
  f.kind = MeasurementKind::point;
  f.point =
      Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.5, 5)).cast<float>();
  f.depth_sigma = static_cast<float>(random.uniform(0.001, 0.1));
  f.landmark_id = static_cast<std::int32_t>(random.below(1000));
  for (auto& c : f.colour) c = static_cast<std::uint8_t>(random.below(256));
  f.descriptor = some_descriptor(random);
  return f;
}

inline FeatureFrame some_features(Random& random, std::size_t count) {
  FeatureFrame frame;
  frame.utime = 7'000'000;
  frame.seq = 77;
  frame.sensor = "head";
  frame.width = 640;
  frame.height = 480;
  frame.fx = 550;
  frame.fy = 551;
  frame.cx = 319;
  frame.cy = 241;
  frame.pixel_sigma = 0.8;
  frame.sharpness = 3.5F;
  frame.has_mount = true;
  frame.T_robot_camera = some_pose(random);
  for (std::size_t i = 0; i < count; ++i) frame.features.push_back(some_feature(random));
  return frame;
}

inline Landmark some_landmark(Random& random, std::int64_t id) {
  Landmark m;
  m.id = id;
  m.mean = Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  m.covariance = some_covariance(random).topLeftCorner<3, 3>();
  m.observations = static_cast<int>(1 + random.below(100));
  m.log_odds = random.normal();
  for (auto& c : m.colour) c = static_cast<std::uint8_t>(random.below(256));
  m.descriptor = some_descriptor(random);
  m.laplacian = random.below(2) != 0 ? 1 : -1;
  return m;
}

/// Points within `range` m; every tenth normal is unknown.
inline DenseKeyframe some_keyframe(Random& random, std::size_t points, double range = 5) {
  DenseKeyframe k;
  k.id = 3;
  k.utime = 9'000'000;
  k.T_world_camera = some_pose(random);
  for (std::size_t i = 0; i < points; ++i) {
    const auto coordinate = [&] { return static_cast<float>(random.uniform(-range, range)); };
    k.cloud.points.emplace_back(coordinate(), coordinate(), coordinate());
    k.cloud.colours.emplace_back(static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8), 7);
    const Eigen::Vector3d normal(random.normal(), random.normal(), random.normal());
    k.cloud.normals.push_back(i % 10 == 0 ? Eigen::Vector3f::Constant(std::nanf(""))
                                          : Eigen::Vector3f(normal.normalized().cast<float>()));
  }
  return k;
}

}  // namespace lcmslam::testing
