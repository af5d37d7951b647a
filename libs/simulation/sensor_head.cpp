#include <lcmslam/simulation/sensor_head.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/simulation/depth_camera.hpp>
#include <lcmslam/simulation/head_piece.hpp>
#include <lcmslam/simulation/tof_camera.hpp>

namespace lcmslam {
namespace {

constexpr double degree = M_PI / 180;

CameraModel pinhole(int width, int height, double horizontal_angle, double vertical_angle) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = width / 2.0 / std::tan(horizontal_angle / 2);
  camera.fy = height / 2.0 / std::tan(vertical_angle / 2);
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  return camera;
}

CameraModel colour_camera() {
  const double horizontal = 60 * degree;
  CameraModel camera = pinhole(640, 480, horizontal, 2 * std::atan(0.75 * std::tan(horizontal / 2)));
  camera.distortion = {-0.12, 0.05, 0.0005, -0.0003, 0};
  return camera;
}

/// Head frame (x forward, y left, z up), tilted and panned, then the camera's axes.
Eigen::Isometry3d mount_pose(const HeadMount& mount) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << mount.forward, 0, mount.height;
  T.rotate(Eigen::AngleAxisd(mount.pan, Eigen::Vector3d::UnitZ()));
  T.rotate(Eigen::AngleAxisd(mount.tilt, Eigen::Vector3d::UnitY()));
  return T * optical_axes();
}

class TofSource : public DepthSource {
 public:
  TofSource(const Scene& scene, const RayCaster& caster, const CameraModel& camera, const TofSensor& sensor)
      : camera_(scene, caster, camera, sensor) {}
  cv::Mat see(const RowPoses& poses, int threads) const override {
    return camera_.see(poses.T_world_camera, threads);
  }
  void measure(const cv::Mat& seen, const PixelNoise& noise, int threads, RgbdFrame& frame) const override {
    TofImage image = camera_.measure(seen, noise, threads);
    frame.depth = image.depth;
    frame.amplitude = image.grey;
  }

 private:
  TofCamera camera_;
};

class StructuredLightSource : public DepthSource {
 public:
  StructuredLightSource(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
                        const StructuredLightSensor& sensor)
      : camera_(scene, caster, camera, sensor) {}
  cv::Mat see(const RowPoses& poses, int threads) const override { return camera_.see(poses, threads); }
  void measure(const cv::Mat& seen, const PixelNoise& noise, int threads, RgbdFrame& frame) const override {
    frame.depth = camera_.measure(seen, noise, threads);
  }

 private:
  DepthCamera camera_;
};

constexpr double least_constant = 1e-4;  // m; a calibration's must be above 0

/// What a user would measure: the noise's mean course, and the wiggle's root mean square, which is systematic
/// but unknown.
DepthNoise told_noise(const TofSensor& sensor) {
  return {std::max(sensor.wiggle / std::sqrt(2.0), least_constant), 0, 0, sensor.noise};
}

/// c + q (z - o)^2 + d z^2 = c + q d / (q + d) o^2 + (q + d) (z - q / (q + d) o)^2.
DepthNoise told_noise(const StructuredLightSensor& sensor, double fx) {
  DepthNoise noise = {sensor.constant, sensor.quadratic, sensor.offset, 0};
  const double disparity = sensor.disparity_sigma / (fx * sensor.baseline);
  if (disparity > 0) {
    noise.quadratic += disparity;
    noise.offset *= sensor.quadratic / noise.quadratic;
    noise.constant += disparity * noise.offset * sensor.offset;
  }
  noise.constant = std::max(noise.constant, least_constant);
  return noise;
}

/// The rest of a head whose calibration is told.
void build(SensorHead& head, const HeadPiece& piece) {
  head.calibration.check();
  head.built = head.calibration;
  head.built.colour = piece.colour(head.calibration.colour);
  head.built.depth = piece.depth(head.calibration.depth);
  head.built.T_robot_camera = piece.mount(head.calibration.T_robot_camera);
  head.clock = piece.clock();
}

SensorHead tof_head(const Scene& scene, const RayCaster& caster, cv::Size size, const HeadPiece& piece) {
  SensorHead head;
  RgbdCalibration& calibration = head.calibration;
  if (size.empty()) size = {176, 144};
  calibration.depth = pinhole(size.width, size.height, 47.5 * degree, 39.6 * degree);
  calibration.T_colour_depth.translation() << 0.08, 0, 0;
  calibration.T_colour_depth.rotate(Eigen::AngleAxisd(-2 * degree, Eigen::Vector3d::UnitY()));  // inwards
  const TofSensor sensor = piece.sensor({});
  calibration.depth_noise = told_noise(sensor);
  calibration.depth_min = sensor.minimum_range;
  calibration.depth_max = sensor.unambiguous_range;
  head.frame_rate = 10;
  head.depth = std::make_unique<TofSource>(scene, caster, piece.depth(calibration.depth), sensor);
  head.tolerance = noise_tolerance(sensor);
  return head;
}

SensorHead rgbd_head(const Scene& scene, const RayCaster& caster, cv::Size size, const HeadPiece& piece) {
  SensorHead head;
  RgbdCalibration& calibration = head.calibration;
  if (size.empty()) size = {640, 480};
  calibration.depth = pinhole(size.width, size.height, 57 * degree, 44.3 * degree);
  calibration.T_colour_depth.translation() << -0.025, 0, 0;
  StructuredLightSensor sensor;
  sensor.disparity_step *= size.width / 640.0;  // the same step in metres
  calibration.depth_noise = told_noise(sensor, calibration.depth.fx);
  calibration.depth_min = sensor.minimum;
  calibration.depth_max = sensor.maximum;
  head.frame_rate = 30;
  head.depth = std::make_unique<StructuredLightSource>(scene, caster, piece.depth(calibration.depth), sensor);
  head.tolerance = noise_tolerance(sensor, calibration.depth.fx);
  return head;
}

}  // namespace

SensorHead make_head(const std::string& name, const Scene& scene, const RayCaster& caster,
                     cv::Size depth_size, std::uint64_t unit) {
  if (name != "tof" && name != "rgbd")
    throw std::invalid_argument("head '" + name + "' is not known: use tof or rgbd");
  const HeadPiece piece(unit);
  SensorHead head = name == "tof" ? tof_head(scene, caster, depth_size, piece)
                                  : rgbd_head(scene, caster, depth_size, piece);
  head.calibration.sensor = name;
  head.calibration.colour = colour_camera();
  head.calibration.has_mount = true;
  head.calibration.T_robot_camera = mount_pose(scene.head);
  build(head, piece);
  return head;
}

SensorHead make_head(const HeadSettings& settings, const Scene& scene, const RayCaster& caster,
                     std::uint64_t unit) {
  const HeadPiece piece(unit);
  SensorHead head;
  RgbdCalibration& calibration = head.calibration;
  calibration.sensor = settings.name;
  calibration.colour = settings.colour.camera();
  calibration.depth = settings.depth.camera();
  calibration.T_colour_depth.translation() = Eigen::Vector3d(settings.translation.data());
  calibration.T_colour_depth.linear() = (Eigen::AngleAxisd(settings.rpy[2], Eigen::Vector3d::UnitZ()) *
                                         Eigen::AngleAxisd(settings.rpy[1], Eigen::Vector3d::UnitY()) *
                                         Eigen::AngleAxisd(settings.rpy[0], Eigen::Vector3d::UnitX()))
                                            .toRotationMatrix();
  calibration.has_mount = true;
  calibration.T_robot_camera = mount_pose(scene.head);
  head.frame_rate = settings.frame_rate;
  head.exposure = settings.exposure;
  head.rolling_shutter = settings.rolling_shutter;
  head.faults = settings.faults;
  if (settings.depth_rolls)
    calibration.rolling_shutter = head.depth_rolling_shutter = settings.rolling_shutter;
  if (settings.kind == "time_of_flight") {
    const TofSensor sensor = piece.sensor(settings.time_of_flight);
    calibration.depth_noise = told_noise(sensor);
    calibration.depth_min = sensor.minimum_range;
    calibration.depth_max = sensor.unambiguous_range;
    head.depth = std::make_unique<TofSource>(scene, caster, piece.depth(calibration.depth), sensor);
    head.tolerance = noise_tolerance(sensor);
  } else {
    const StructuredLightSensor& sensor = settings.triangulation;
    calibration.depth_noise = told_noise(sensor, calibration.depth.fx);
    calibration.depth_min = sensor.minimum;
    calibration.depth_max = sensor.maximum;
    head.depth =
        std::make_unique<StructuredLightSource>(scene, caster, piece.depth(calibration.depth), sensor);
    head.tolerance = noise_tolerance(sensor, calibration.depth.fx);
  }
  build(head, piece);
  return head;
}

}  // namespace lcmslam
