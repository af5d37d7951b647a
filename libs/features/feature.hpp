#pragma once
// A SURF feature as it travels between processes, with its 3-D point where there is depth.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// 64-D SURF descriptor, one byte a component: value = 128 + 127 * component.
using Descriptor = std::array<std::uint8_t, 64>;

/// What `Feature::point` means.
enum class MeasurementKind : std::uint8_t {
  point = 0,         ///< 3-D point in the colour camera frame
  bearing = 1,       ///< no depth: only the pixel is known, point is NaN
  planar = 2,        ///< (x, y, 0) in the robot frame: a laser or fiducial seen in the plane; noise
                     ///< depth_sigma (m) on each axis
  range_bearing = 3  ///< (range m, bearing rad, 0) in the robot frame; noise depth_sigma (m) of the range,
                     ///< the frame's pixel_sigma / fx (rad) of the bearing
};

/// Bytes of a 64-D float descriptor: rounded, clamped to 0..255 (NaN becomes 0).
Descriptor to_bytes(const float* descriptor64);

struct Feature {
  float x = 0, y = 0;         ///< pixel in the ideal (undistorted) colour image, K of the FeatureFrame
  float size = 0;             ///< diameter of the blob, pixels
  float angle = 0;            ///< radians, clockwise in the image; 0 for upright
  float response = 0;         ///< determinant of the Hessian
  std::int8_t laplacian = 0;  ///< sign of the trace: -1 or 1
  std::int8_t octave = 0;
  MeasurementKind kind = MeasurementKind::bearing;
  Eigen::Vector3f point = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  float depth_sigma = std::numeric_limits<float>::quiet_NaN();  ///< m, of the depth z
  std::int32_t landmark_id = -1;         ///< known identity (fiducial, beacon), -1 if none
  std::array<std::uint8_t, 3> colour{};  ///< R, G, B at the feature
  Descriptor descriptor{};
};

/// All features of one colour image, with what is needed to use them.
struct FeatureFrame {
  Utime utime = 0;       ///< of the colour image
  std::int64_t seq = 0;  ///< of the CAMERA message
  std::string sensor;
  int width = 0, height = 0;              ///< of the colour image, pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< ideal pinhole of x, y
  double pixel_sigma = 1;                 ///< standard deviation of x and y, pixels
  float sharpness = 0;                    ///< mean absolute gradient of the image, grey values a pixel
  bool has_mount = false;
  Eigen::Isometry3d T_robot_camera = optical_axes();
  std::vector<Feature> features;
};

/// Standard deviation of one feature's pixel. A blob is found the less sharply the larger it is (Zeisl et al.
/// 2009, "Estimation of location uncertainty for scale invariant feature points"), and a large one on a
/// slanted wall slides along it as the robot goes by: pixel_sigma is that of features of 25 pixels, 17 and
/// less have 0.7 of it. Without a size: pixel_sigma.
double pixel_sigma(const Feature& feature, const FeatureFrame& frame);

/// 3x3 covariance of a `point` feature in the camera frame: depth_sigma along the viewing ray (which is that
/// of z, and beside the axis too small by the ray's cosine: docs/notebook/features.md), pixel_sigma() * z / f
/// across it. Throws std::invalid_argument when the feature is no `point`, does not lie in front of the
/// camera, or a sigma or focal length is not positive.
Eigen::Matrix3d point_covariance(const Feature& feature, const FeatureFrame& frame);

}  // namespace lcmslam
