// FastSLAM with a camera that reads its rows one after the other while the robot turns.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include <lcmslam/associations_t.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/landmarks_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "procs/fastslam/fastslam_node.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam {
namespace {

constexpr double turn_rate = 0.8, readout = 0.03;  // rad/s, s
constexpr Utime begin = 1'000'000, odometry_period = 20'000, image_period = 100'000;
constexpr int images = 15;

RgbdCalibration camera(double rolling_shutter) {
  RgbdCalibration c;
  c.sensor = "rolls";
  c.colour = c.depth = CameraModel{640, 480, 525, 525, 319.5, 239.5, {}};
  c.depth_registered = true;
  c.rolling_shutter = rolling_shutter;
  c.has_mount = true;
  c.T_robot_camera = Eigen::Translation3d(0.1, 0, 1) * optical_axes();
  return c;
}

Eigen::Isometry3d T_world_robot(double seconds) {
  return planar_pose(0, 0, turn_rate * seconds);
}

/// On all sides of the robot.
std::vector<Eigen::Vector3d> landmarks() {
  Random random(5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i) {
    const double angle = 2 * M_PI * random.uniform(), distance = 2 + 2 * random.uniform();
    points.emplace_back(distance * std::cos(angle), distance * std::sin(angle), 2 * random.uniform());
  }
  return points;
}

/// Each row from where the camera is when it is read.
FeatureFrame see(const RgbdCalibration& c, Utime utime) {
  FeatureFrame frame;
  frame.utime = utime;
  frame.width = c.colour.width, frame.height = c.colour.height;
  frame.fx = c.colour.fx, frame.fy = c.colour.fy, frame.cx = c.colour.cx, frame.cy = c.colour.cy;
  frame.pixel_sigma = 0.5;
  frame.has_mount = true;
  frame.T_robot_camera = c.T_robot_camera;
  const double seconds = 1e-6 * static_cast<double>(utime - begin);
  std::uint8_t number = 0;
  for (const Eigen::Vector3d& landmark : landmarks()) {
    Random words(100 + number++);
    Eigen::Vector3d p;
    double row = 0;
    for (int look = 0; look < 3; ++look) {
      const double late = ((row + 0.5) / frame.height - 0.5) * readout;
      p = (T_world_robot(seconds + late) * c.T_robot_camera).inverse() * landmark;
      row = frame.cy + frame.fy * p.y() / p.z();
    }
    Feature f;
    f.x = static_cast<float>(frame.cx + frame.fx * p.x() / p.z());
    f.y = static_cast<float>(row);
    if (!(p.z() > 0.5) || f.x < 0 || f.x >= 640 || f.y < 0 || f.y >= 480) continue;
    f.size = 20;
    f.kind = MeasurementKind::point;
    f.point = p.cast<float>();
    f.depth_sigma = 0.005F;
    for (std::uint8_t& byte : f.descriptor) byte = static_cast<std::uint8_t>(255 * words.uniform());
    frame.features.push_back(f);
  }
  return frame;
}

/// Turns on the spot; gives what was seen. In each image others of the features have no depth where
/// `bearings`.
std::vector<FeatureFrame> drive(testing::TestBus& bus, double told_shutter, bool bearings) {
  bus.add<FastSlamNode>(ConfigNode::parse("{particles: 40}"));
  const RgbdCalibration c = camera(told_shutter);
  bus.deliver("CAMERA_CALIBRATION", to_message(c));
  std::vector<FeatureFrame> frames;
  Utime odometry = begin - 4 * odometry_period;
  for (int k = 0; k < images; ++k) {
    const Utime utime = begin + k * image_period;
    for (; odometry <= utime; odometry += odometry_period) {
      MotionSample sample;
      sample.utime = odometry;
      sample.T_odom_robot = T_world_robot(1e-6 * static_cast<double>(odometry - begin));
      sample.covariance = Matrix6d::Identity() * 1e-6 * static_cast<double>(odometry) * 1e-6;
      bus.deliver("ODOMETRY", to_message(sample, "wheels"));
    }
    frames.push_back(see(c, utime));
    if (bearings)
      for (std::size_t i = static_cast<std::size_t>(k % 3); i < frames.back().features.size(); i += 3)
        frames.back().features[i].kind = MeasurementKind::bearing;
    bus.deliver("FEATURES", to_message(frames.back()));
  }
  bus.finish();
  return frames;
}

/// m, RMS of the landmarks' places in the map; their number must be a map's.
double map_error(double told_shutter) {
  testing::TestBus bus;
  drive(bus, told_shutter, false);
  std::map<std::int64_t, Eigen::Vector3d> map;
  for (const landmarks_t& tile : bus.on<landmarks_t>("FASTSLAM_LANDMARKS"))
    for (const landmark_t& l : tile.landmarks) map[l.id] = {l.mean[0], l.mean[1], l.mean[2]};
  EXPECT_GT(map.size(), 40U);
  double sum = 0;
  for (const auto& [id, place] : map) {
    double nearest = 1;
    for (const Eigen::Vector3d& truth : landmarks()) nearest = std::min(nearest, (truth - place).norm());
    sum += nearest * nearest;
  }
  return std::sqrt(sum / static_cast<double>(map.size()));
}

// 24 mrad from the first row to the last: 7 cm in 3 m.
TEST(RollingCamera, FastSlamMapsWhatItsRowsShearedWhereItIsToldOfIt) {
  const double straight = map_error(readout), sheared = map_error(0);
  EXPECT_LT(straight, 0.003);
  EXPECT_GT(sheared, 3 * straight);
}

// Straightened for the filter alone: who draws them over the image must find them where they were seen. Of
// what has no depth it is the pixel that is straightened.
TEST(RollingCamera, AssociationsNamePixelsAsSeen) {
  testing::TestBus bus;
  const std::vector<FeatureFrame> frames = drive(bus, readout, true);
  const auto messages = bus.on<associations_t>("FASTSLAM_ASSOCIATIONS");
  ASSERT_EQ(messages.size(), frames.size());
  int bearings = 0;
  for (std::size_t k = 0; k < frames.size(); ++k)
    for (const association_t& association : messages[k].associations) {
      const Feature& seen = frames[k].features.at(static_cast<std::size_t>(association.feature));
      bearings += seen.kind == MeasurementKind::bearing;
      EXPECT_FLOAT_EQ(association.x, seen.x) << "image " << k;
      EXPECT_FLOAT_EQ(association.y, seen.y) << "image " << k;
    }
  EXPECT_GT(bearings, 50);
}

}  // namespace
}  // namespace lcmslam
