#pragma once
// What is compared, as Ceres differentiates it by itself.
//
// A keyframe is nine numbers that begin at 0: T_camera_world = (R(turn), shift) * T_start, turn first, and by
// how much it turns faster than was told (rad/s). Whatever was measured at another moment than the keyframe's
// is moved by the camera's own velocity: after s seconds a point p of its frame is at exp(-s twist) p.

#include <ceres/rotation.h>
#include <Eigen/Core>

#include <lcmslam/calibration/self/range_curve.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam::residuals {

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

constexpr int keyframe_size = 9, turn_rate_at = 6;  ///< of a keyframe's numbers; where its turn rate begins

/// A point of the world in a keyframe's camera, `seconds` after the keyframe's moment.
template <class T>
Vector3<T> in_camera(const Eigen::Isometry3d& T_start, const Vector6d& twist, const T* keyframe,
                     const T* point, const T& seconds) {
  const Vector3<T> begun =
      T_start.linear().cast<T>() * Eigen::Map<const Vector3<T>>(point) + T_start.translation().cast<T>();
  Vector3<T> p, moved;
  ceres::AngleAxisRotatePoint(keyframe, begun.data(), p.data());
  p += Eigen::Map<const Vector3<T>>(keyframe + 3);
  const Vector3<T> rate = twist.tail<3>().cast<T>() + Eigen::Map<const Vector3<T>>(keyframe + turn_rate_at);
  const Vector3<T> turn = -seconds * rate;
  ceres::AngleAxisRotatePoint(turn.data(), p.data(), moved.data());
  return moved - seconds * twist.head<3>().cast<T>();
}

/// intrinsics: fx fy cx cy k1 k2 p1 p2 k3; `rational`: k4 k5 k6. False behind the camera.
template <class T>
bool project(const T* c, const double* rational, const Vector3<T>& p, T* pixel) {
  if (!(p.z() > T(1e-3))) return false;
  const T x = p.x() / p.z(), y = p.y() / p.z();
  const T s = x * x + y * y;
  const T f = (T(1) + s * (c[4] + s * (c[5] + s * c[8]))) /
              (T(1) + s * (rational[0] + s * (rational[1] + s * rational[2])));
  pixel[0] = c[0] * (x * f + T(2) * c[6] * x * y + c[7] * (s + T(2) * x * x)) + c[2];
  pixel[1] = c[1] * (y * f + c[6] * (s + T(2) * y * y) + T(2) * c[7] * x * y) + c[3];
  return true;
}

/// Inverse depth around a pixel of the depth image: a plane's is linear there, once it is freed of what all
/// ranges err by.
struct Patch {
  double u = 0, v = 0;                           ///< pixel
  double inverse = 0, along_u = 0, along_v = 0;  ///< 1/m, 1/m a pixel
  double sigma = 0;                              ///< m, of the depth at (u, v)
  double freed = 0;                              ///< m, of the range there, by the curve as it was
};

/// A landmark and the colour pixel where it was seen; pixels by sigma.
struct Reprojection {
  Eigen::Isometry3d T_start;
  Vector6d twist;
  Eigen::Vector2d pixel;
  double row;  // of the image's height, -0.5 to 0.5
  double rational[3];
  double sigma;

  template <class T>
  bool operator()(const T* keyframe, const T* point, const T* intrinsics, const T* rows, T* residual) const {
    T seen[2];
    if (!project(intrinsics, rational, in_camera(T_start, twist, keyframe, point, T(row * rows[0])), seen))
      return false;
    residual[0] = (seen[0] - pixel.x()) / sigma;
    residual[1] = (seen[1] - pixel.y()) / sigma;
    return true;
  }
};

/// `p`: the landmark in the depth camera; depth: scale, offset, clock, rows, tilt in x and y. A range is
/// `scale` times the measured one + `offset` + `curve`. In what the sensor measures: a world that shrinks
/// together with its scale must not err by less.
template <class T>
T depth_error(const Patch& patch, const T* pixel, const Vector3<T>& p, const T* depth, const T& curve) {
  const T inverse =
      patch.inverse + patch.along_u * (pixel[0] - patch.u) + patch.along_v * (pixel[1] - patch.v);
  const T level = (p.z() - (depth[1] + curve) * p.z() / p.norm()) / depth[0];
  const T measured = level / (T(1) + level * (depth[4] * p.x() + depth[5] * p.y()) / p.z());
  return (T(1) / inverse - measured) / patch.sigma;
}

/// Of a RangeCurve's four numbers.
template <class T>
T curve_at(const RangeCurve::Place& place, const T* a, const T* b, const T* c, const T* d) {
  return place.weights[0] * a[0] + place.weights[1] * b[0] + place.weights[2] * c[0] +
         place.weights[3] * d[0];
}

/// s from the colour image's stamp to the moment at which a row of the depth image was measured; `depth` as
/// for depth_error().
template <class T>
T seconds_to_depth(double lag, double row, const T* depth) {
  return T(lag) + depth[2] + row * depth[3];
}

/// A landmark and the surface that a depth camera of its own measured there; m by sigma.
struct SurfaceOfOwnCamera {
  Eigen::Isometry3d T_start, T_colour_depth_start;
  Vector6d twist;
  double focal[4];  // fx fy cx cy of the depth camera
  double lens[5], rational[3];
  double lag;  // s from the colour image's stamp to depth's
  double row;
  Patch patch;
  RangeCurve::Place range;

  template <class T>
  bool operator()(const T* keyframe, const T* point, const T* extrinsics, const T* depth, const T* a,
                  const T* b, const T* c, const T* d, T* residual) const {
    const T seconds = seconds_to_depth(lag, row, depth);
    const Vector3<T> p = in_camera(T_start, twist, keyframe, point, seconds);
    const Eigen::Isometry3d T_depth_colour = T_colour_depth_start.inverse();
    const Vector3<T> begun = T_depth_colour.linear().cast<T>() * p + T_depth_colour.translation().cast<T>() -
                             Eigen::Map<const Vector3<T>>(extrinsics);
    const Vector3<T> back = -Eigen::Map<const Vector3<T>>(extrinsics + 3);
    Vector3<T> q;
    ceres::AngleAxisRotatePoint(back.data(), begun.data(), q.data());
    T camera[9], seen[2];
    for (int i = 0; i < 4; ++i) camera[i] = T(focal[i]);
    for (int i = 0; i < 5; ++i) camera[4 + i] = T(lens[i]);
    if (!project(camera, rational, q, seen)) return false;
    residual[0] = depth_error(patch, seen, q, depth, curve_at(range, a, b, c, d) - patch.freed);
    return true;
  }
};

/// The same where depth pixels are colour pixels.
struct SurfaceOfColour {
  Eigen::Isometry3d T_start;
  Vector6d twist;
  double rational[3];
  double lag, row;
  Patch patch;
  RangeCurve::Place range;

  template <class T>
  bool operator()(const T* keyframe, const T* point, const T* intrinsics, const T* depth, const T* a,
                  const T* b, const T* c, const T* d, T* residual) const {
    const T seconds = seconds_to_depth(lag, row, depth);
    const Vector3<T> p = in_camera(T_start, twist, keyframe, point, seconds);
    T seen[2];
    if (!project(intrinsics, rational, p, seen)) return false;
    residual[0] = depth_error(patch, seen, p, depth, curve_at(range, a, b, c, d) - patch.freed);
    return true;
  }
};

/// A keyframe's turn rate as it was told, less what the keyframe began with; rad/s.
struct ToldTurnRate {
  Eigen::Vector3d told;
  double sigma;
  template <class T>
  bool operator()(const T* keyframe, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = (keyframe[turn_rate_at + i] - told(i)) / sigma;
    return true;
  }
};

/// A number that the start calibration says.
struct Prior {
  int index;
  double value, sigma;
  template <class T>
  bool operator()(const T* block, T* residual) const {
    residual[0] = (block[index] - value) / sigma;
    return true;
  }
};

/// Pixels are as high as they are wide, or as the start says.
struct Aspect {
  double ratio, sigma;  // of fx / fy
  template <class T>
  bool operator()(const T* intrinsics, T* residual) const {
    residual[0] = (intrinsics[0] / (intrinsics[1] * ratio) - T(1)) / sigma;
    return true;
  }
};

}  // namespace lcmslam::residuals
