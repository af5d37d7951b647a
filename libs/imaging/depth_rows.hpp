#pragma once
// What a row of a depth image becomes, a piece of it at a time: the loops that whole images and the
// surroundings of some pixels share, so that both have the same bits.

#include <cstdint>

#include <lcmslam/imaging/calibration.hpp>

namespace lcmslam {

/// Range, noise and movement of a depth camera's pixels, in single precision.
struct DepthRowGeometry {
  float nearest, farthest;                       ///< mm
  float constant, quadratic, offset, amplitude;  ///< DepthNoise's
  float R[9], t[3];                              ///< row-major
};

/// `T` moves the depth camera's points to where they are wanted.
DepthRowGeometry depth_row_geometry(const RgbdCalibration& calibration, const Eigen::Isometry3d& T);

/// A colour camera's lens in single precision: good to 1e-3 pixel.
struct LensRowGeometry {
  float fx, fy, cx, cy, right, bottom;  ///< pixels
  float k1, k2, p1, p2, k3, k4, k5, k6;
};

LensRowGeometry lens_row_geometry(const CameraModel& camera);

/// Depths (mm) in range become points z * ray (x, y, z one after the other, m) with their standard
/// deviation (m); the others are NaN. `ray` as ray_table(). `amplitude`: of these pixels, or nullptr.
void unproject_row(const std::uint16_t* depth, const std::uint8_t* amplitude, const float* ray, int columns,
                   const DepthRowGeometry& geometry, float* point, float* sigma);

/// Moves points by R and t.
void move_row(int columns, const DepthRowGeometry& geometry, float* point);

/// Where the camera sees points: pixels and depths; u and v are NaN outside of its image, as
/// CameraModel::project() and contains() have it.
void project_row(const float* point, int columns, const LensRowGeometry& lens, float* u, float* v, float* z);

}  // namespace lcmslam
