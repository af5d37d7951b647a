#include <lcmslam/imaging/io/foreign_calibration.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

namespace lcmslam {
namespace {

using Names = std::vector<std::string>;  // the key's usual name first

const Names width_names = {"image_width", "image_Width", "width"};
const Names height_names = {"image_height", "image_Height", "height"};
const Names matrix_names = {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"};
const Names distortion_names = {"distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "D", "d"};

std::optional<std::string> key_of(const ConfigNode& config, const Names& names) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const auto& n) { return config.has(n); });
  return found == names.end() ? std::nullopt : std::optional<std::string>(*found);
}

int read_size(const ConfigNode& config, const Names& names) {
  const auto key = key_of(config, names);
  if (!key)
    config.fail("", "the key " + names.front() +
                        " is missing: add image_width and image_height, the pixels of the images");
  return static_cast<int>(config.number(*key, {1, max_image_side}));
}

/// A matrix with rows, cols and data; in ROS's message (K, D) the numbers alone.
std::vector<double> read_matrix(const ConfigNode& config, const std::string& key) {
  const bool of_message = key.size() == 1;
  return of_message ? config.get(key, std::vector<double>{})
                    : config.section(key).get("data", std::vector<double>{});
}

void read_pinhole(const ConfigNode& config, const std::string& key, CameraModel& camera) {
  const std::vector<double> m = read_matrix(config, key);
  const bool is_one =
      m.size() == 9 && m[0] > 0 && m[4] > 0 && m[3] == 0 && m[6] == 0 && m[7] == 0 && m[8] == 1;
  if (!is_one)
    config.fail(
        key, "is no camera matrix: its data must be [fx, 0, cx, 0, fy, cy, 0, 0, 1] with fx and fy above 0");
  if (std::abs(m[1]) > 1e-3 * m[0])
    config.fail(key, "its pixels are skewed (second number " + std::to_string(m[1]) + "): must be 0");
  camera.fx = m[0];
  camera.cx = m[2];
  camera.fy = m[4];
  camera.cy = m[5];
}

void check_lens_model(const ConfigNode& config) {
  const std::string model = config.get("distortion_model", "");
  const Names known = {"", "none", "plumb_bob", "rational_polynomial"};
  if (std::find(known.begin(), known.end(), model) == known.end())
    config.fail("distortion_model",
                "'" + model +
                    "' is not known: must be plumb_bob or rational_polynomial (calibrate with "
                    "one of them, or rectify the images and leave the distortion out)");
  // OpenCV's calibration sample names no model, and gives a fisheye's four coefficients the usual name.
  if (const std::string fisheye = config.get("fisheye_model", "0"); fisheye != "0")
    config.fail("fisheye_model",
                "fisheye_model is " + fisheye +
                    ": must be 0, a fisheye's coefficients mean something else (calibrate without it, or "
                    "rectify the images and leave the distortion out)");
}

/// OpenCV's k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]]; thin prism and tilt must be 0.
std::vector<double> read_distortion(const ConfigNode& config, const std::string& key) {
  std::vector<double> k = read_matrix(config, key);
  while (k.size() > 8 && k.back() == 0) k.pop_back();
  if (std::all_of(k.begin(), k.end(), [](double value) { return value == 0; })) return {};
  if (k.size() == 6 || k.size() == 7) k.resize(8);
  if (k.size() != 4 && k.size() != 5 && k.size() != 8)
    config.fail(key,
                std::to_string(k.size()) +
                    " coefficients: must be 4, 5 or 8 (k1 k2 p1 p2 [k3 [k4 k5 k6]]); what follows must be 0");
  return k;
}

}  // namespace

ConfigNode load_calibration_yaml(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text(5, '\0');
  stream.read(text.data(), 5);
  if (!stream || text != "%YAML") return ConfigNode::load(file);
  text.front() = '#';
  text.append(std::istreambuf_iterator<char>(stream), {});
  return ConfigNode::parse(text, file.string());
}

bool is_foreign_camera(const ConfigNode& config) {
  return key_of(config, matrix_names).has_value();
}

CameraModel read_foreign_camera(const ConfigNode& config) {
  for (const std::string& key : config.keys()) config.ignore(key);
  CameraModel camera;
  camera.width = read_size(config, width_names);
  camera.height = read_size(config, height_names);
  const auto matrix = key_of(config, matrix_names);
  if (!matrix) config.fail("", "the key camera_matrix is missing");
  read_pinhole(config, *matrix, camera);
  check_lens_model(config);
  if (const auto key = key_of(config, distortion_names)) camera.distortion = read_distortion(config, *key);
  return camera;
}

std::string foreign_camera_name(const ConfigNode& config, const std::string& otherwise) {
  return config.get("camera_name", otherwise);
}

}  // namespace lcmslam
