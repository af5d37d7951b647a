#include <lcmslam/imaging/io/calibration_file.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include <lcmslam/imaging/io/foreign_calibration.hpp>

namespace lcmslam {
namespace {

constexpr double farthest_camera = 20,
                 farthest_depth_camera = 2;  // m, from the robot's and the head's middle

/// Intrinsics in a file of their own, as ROS and OpenCV write them, beside the file that names it.
CameraModel load_camera(const ConfigNode& node) {
  const std::filesystem::path file = node.folder("file") / node.text("file");
  if (!std::filesystem::exists(file)) node.fail("file", file.string() + " is not there");
  const ConfigNode camera = load_calibration_yaml(file);
  if (!is_foreign_camera(camera))
    node.fail("file",
              file.string() + " has no camera_matrix: it must be a camera_info of ROS or a file of OpenCV");
  return read_foreign_camera(camera);
}

CameraModel read_camera(const ConfigNode& node) {
  if (node.has("file")) return load_camera(node);
  CameraModel camera;
  camera.width = static_cast<int>(node.number("width", {1, 8192}));
  camera.height = static_cast<int>(node.number("height", {1, 8192}));
  camera.fx = node.number("fx", {1e-3, 1e6});
  camera.fy = node.number("fy", {1e-3, 1e6});
  camera.cx = node.number("cx");
  camera.cy = node.number("cy");
  camera.distortion = node.get("distortion", std::vector<double>{});
  if (std::all_of(camera.distortion.begin(), camera.distortion.end(), [](double k) { return k == 0; }))
    camera.distortion.clear();
  return camera;
}

/// Metres; what lies beyond any robot's size is taken for millimetres.
std::vector<double> read_translation(const ConfigNode& node, double farthest) {
  const std::vector<double> t = node.numbers("translation", 3);
  for (const double coordinate : t)
    if (!(std::abs(coordinate) <= farthest)) {
      std::ostringstream text;
      text << "is in metres, and " << coordinate << " m is too far: must be within " << farthest << " m ("
           << coordinate << " mm are " << 1e-3 * coordinate << ")";
      node.fail("translation", text.str());
    }
  return t;
}

/// Radians; what is more than a turn is taken for degrees.
std::vector<double> read_rpy(const ConfigNode& node) {
  const std::vector<double> rpy = node.numbers("rpy", 3);
  for (const double angle : rpy)
    if (!(std::abs(angle) <= 2 * M_PI)) {
      std::ostringstream text;
      text << "is in radians, and " << angle << " is more than a turn (" << angle << " degrees are "
           << angle * M_PI / 180 << ")";
      node.fail("rpy", text.str());
    }
  return rpy;
}

Eigen::Isometry3d read_quaternion(const ConfigNode& node, double farthest) {
  const std::vector<double> translation = read_translation(node, farthest);
  const std::vector<double> quaternion = node.numbers("quaternion", 4);
  double norm = 0;
  for (double q : quaternion) norm += q * q;
  if (!(std::abs(std::sqrt(norm) - 1) < 1e-2))
    node.fail("quaternion",
              "must be a unit quaternion [w, x, y, z], its length is " + std::to_string(std::sqrt(norm)));
  return make_transform(translation.data(), quaternion.data());
}

// rpy turns the head as a body (x forward, y left, z up): Rz(yaw) Ry(pitch) Rx(roll), then the camera's
// axes. A head inclined downwards by 20 degrees is rpy [0, 0.349, 0].
Eigen::Isometry3d read_mount(const ConfigNode& node) {
  if (!node.has("rpy")) return read_quaternion(node, farthest_camera);
  if (node.has("quaternion")) node.fail("rpy", "give rpy or quaternion, not both");
  const std::vector<double> t = read_translation(node, farthest_camera);
  const std::vector<double> rpy = read_rpy(node);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << t[0], t[1], t[2];
  T.linear() = (Eigen::AngleAxisd(rpy[2], Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(rpy[1], Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(rpy[0], Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T * optical_axes();
}

DepthNoise read_noise(const ConfigNode& node) {
  DepthNoise noise;
  noise.constant = node.get("constant", noise.constant, Range{1e-6, 1});
  noise.quadratic = node.get("quadratic", noise.quadratic, Range{0, 1});
  noise.offset = node.get("offset", noise.offset, Range{0, 10});
  noise.amplitude = node.get("amplitude", noise.amplitude, Range{0, 1});
  return noise;
}

DepthError read_error(const ConfigNode& node) {
  DepthError error;
  error.offset = node.get("offset", 0.0, Range{-1, 1});
  error.scale = node.get("scale", 0.0, Range{-0.2, 0.2});
  error.wiggle = node.get("wiggle", 0.0, Range{-1, 1});
  error.period = node.get("period", error.period, Range{0.05, 100});
  error.phase = node.get("phase", 0.0, Range{-100, 100});
  error.tilt_x = node.get("tilt_x", 0.0, Range{-0.2, 0.2});
  error.tilt_y = node.get("tilt_y", 0.0, Range{-0.2, 0.2});
  return error;
}

void check(const RgbdCalibration& calibration, const ConfigNode& config) {
  try {
    calibration.check();
  } catch (const std::invalid_argument& error) {
    throw ConfigError(config.where() + ": " + error.what());
  }
}

RgbdCalibration foreign_head(const ConfigNode& config) {
  RgbdCalibration calibration;
  calibration.sensor = foreign_camera_name(config, calibration.sensor);
  calibration.colour = calibration.depth = read_foreign_camera(config);
  calibration.depth_registered = true;
  check(calibration, config);
  return calibration;
}

}  // namespace

RgbdCalibration read_calibration(const ConfigNode& config) {
  RgbdCalibration calibration;
  calibration.sensor = config.get("sensor", calibration.sensor);
  if (!config.has("colour"))
    config.fail(
        "colour",
        "the key colour is missing: give the colour camera's intrinsics (config/calibration/tum_fr1.yaml "
        "explains every key), or a file of ROS or OpenCV with camera_matrix");
  calibration.colour = read_camera(config.section("colour"));
  calibration.depth_registered = config.get("depth_registered", false);
  if (calibration.depth_registered) {
    for (const char* key : {"depth", "colour_depth"})
      if (config.has(key))
        config.fail(key,
                    "must be left out when depth_registered is true: the depth image has the colour "
                    "camera's geometry");
    calibration.depth = calibration.colour;
  } else {
    for (const char* key : {"depth", "colour_depth"})
      if (!config.has(key))
        config.fail(key, std::string("the key ") + key +
                             " is missing: give depth and colour_depth, or depth_registered: true");
    calibration.depth = read_camera(config.section("depth"));
    calibration.T_colour_depth = read_quaternion(config.section("colour_depth"), farthest_depth_camera);
  }
  if (config.has("mount")) {
    calibration.has_mount = true;
    calibration.T_robot_camera = read_mount(config.section("mount"));
  }
  calibration.depth_clock_offset = config.get("depth_clock_offset", 0.0, Range{-10, 10});
  calibration.rolling_shutter = config.get("rolling_shutter", 0.0, Range{0, 0.1});
  if (config.has("depth_noise")) calibration.depth_noise = read_noise(config.section("depth_noise"));
  if (config.has("depth_error")) calibration.depth_error = read_error(config.section("depth_error"));
  calibration.depth_min = config.get("depth_min", calibration.depth_min, Range{0, 65});
  calibration.depth_max = config.get("depth_max", calibration.depth_max, Range{0, 65.535});
  calibration.pixel_sigma = config.get("pixel_sigma", calibration.pixel_sigma, Range{1e-3, 100});
  check(calibration, config);
  return calibration;
}

RgbdCalibration load_calibration(const std::filesystem::path& file) {
  const ConfigNode config = load_calibration_yaml(file);
  RgbdCalibration calibration = is_foreign_camera(config) ? foreign_head(config) : read_calibration(config);
  config.finish();
  return calibration;
}

std::string describe(const RgbdCalibration& calibration) {
  const auto size = [](const CameraModel& camera) {
    return std::to_string(camera.width) + "x" + std::to_string(camera.height);
  };
  return "sensor " + calibration.sensor + ", colour " + size(calibration.colour) + ", depth " +
         (calibration.depth_registered ? "registered to it" : size(calibration.depth)) +
         (calibration.has_mount ? ", mounted on the robot" : ", hand-held (no mount)");
}

std::optional<RgbdCalibration> find_calibration(const std::string& sensor,
                                                const std::filesystem::path& folder) {
  const auto of_a_name = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; };
  if (sensor.empty() || !std::all_of(sensor.begin(), sensor.end(), of_a_name)) return std::nullopt;
  const std::filesystem::path file = folder / (sensor + ".yaml");
  if (!std::filesystem::exists(file)) return std::nullopt;
  return load_calibration(file);
}

}  // namespace lcmslam
