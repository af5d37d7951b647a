#pragma once
// Pinhole camera with Brown-Conrady lens distortion (OpenCV's order k1 k2 p1 p2 k3 [k4 k5 k6]).
// Camera frame: x right, y down, z forward; pixel (0, 0) is the centre of the upper left pixel.

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace lcmslam {

/// Larger images are refused before any memory is taken.
constexpr int max_image_side = 8192;  ///< pixels
constexpr std::int64_t max_image_pixels = 32 << 20;

struct CameraModel {
  int width = 0;  ///< pixels
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  std::vector<double> distortion;         ///< 0, 4, 5 or 8 coefficients

  /// Pixel of a point in the camera frame (m), distortion included; nothing when behind the camera or
  /// so far to the side that the lens polynomial folds back. The pixel may lie outside the image.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;

  /// Ray (x/z, y/z, 1) through a pixel, distortion removed (Newton's method, exact to 1e-9). Finite
  /// everywhere in an image whose model passes check(); NaN far outside where the polynomial folds.
  Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const;

  /// Pixel of the same ray in the ideal pinhole image with the same fx, fy, cx, cy.
  Eigen::Vector2d undistort(const Eigen::Vector2d& pixel) const;

  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 && pixel.y() < height - 0.5;
  }
  bool operator==(const CameraModel& other) const {
    return width == other.width && height == other.height && fx == other.fx && fy == other.fy &&
           cx == other.cx && cy == other.cy && distortion == other.distortion;
  }
  cv::Matx33d matrix() const { return {fx, 0, cx, 0, fy, cy, 0, 0, 1}; }

  /// The same lens at another image size: pixel areas scale, so pixel (u, v) moves to
  /// ((u + 0.5) * factor - 0.5, ...).
  CameraModel scaled(double factor) const;

  /// Throws std::invalid_argument naming the value that is wrong, `name` in front. A lens model that
  /// cannot be inverted inside the image is wrong too.
  void check(const std::string& name) const;
};

/// x/z and y/z of the rays of a row's pixels, as CameraModel::ray() gives them, in a fraction of its time.
void ray_row(const CameraModel& camera, int row, double* x, double* y);

/// Rays of all pixels, CV_32FC2 of (x/z, y/z): computed once for each camera and shared by all who ask, in
/// any thread; nobody may write to it.
cv::Mat ray_table(const CameraModel& camera);

}  // namespace lcmslam
