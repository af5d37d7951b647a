#pragma once
// The camera model as Ceres differentiates it: the same as CameraModel::project, which a test says.

#include <Eigen/Core>
#include <vector>

namespace lcmslam {

/// Pixel of a point before the camera. `k`: fx, fy, cx, cy; `d` as CameraModel::distortion.
template <class T>
Eigen::Matrix<T, 2, 1> project_through_lens(const T* k, const std::vector<double>& d,
                                            const Eigen::Matrix<T, 3, 1>& point) {
  const T x = point.x() / point.z(), y = point.y() / point.z();
  if (d.empty()) return {k[0] * x + k[2], k[1] * y + k[3]};
  const T s = x * x + y * y;
  T f = 1.0 + s * (d[0] + s * (d[1] + s * (d.size() > 4 ? d[4] : 0.0)));
  if (d.size() > 5) f /= 1.0 + s * (d[5] + s * (d[6] + s * d[7]));
  const T xd = x * f + 2.0 * d[2] * x * y + d[3] * (s + 2.0 * x * x);
  const T yd = y * f + d[2] * (s + 2.0 * y * y) + 2.0 * d[3] * x * y;
  return {k[0] * xd + k[2], k[1] * yd + k[3]};
}

}  // namespace lcmslam
