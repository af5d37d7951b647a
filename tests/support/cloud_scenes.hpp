#pragma once
// Synthetic clouds with exact normals, and recorded ones.

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

/// Adds a grid on the rectangle origin + [0, 1] a + [0, 1] b, normal along a x b.
inline void add_rectangle(Cloud& cloud, const Eigen::Vector3d& origin, const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b, double spacing = 0.05) {
  const Eigen::Vector3f normal = a.cross(b).normalized().cast<float>();
  const int rows = static_cast<int>(a.norm() / spacing);
  const int columns = static_cast<int>(b.norm() / spacing);
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j <= columns; ++j) {
      const Eigen::Vector3d p = origin + a * i / rows + b * j / columns;
      cloud.points.emplace_back(p.cast<float>());
      cloud.normals.push_back(normal);
    }
}

/// One wall, 2 m ahead.
inline Cloud wall(double spacing = 0.05) {
  Cloud cloud;
  add_rectangle(cloud, {2, -1.5, -1}, {0, 0, 2}, {0, 3, 0}, spacing);
  return cloud;
}

/// Two long walls and the ground along x.
inline Cloud corridor() {
  Cloud cloud;
  add_rectangle(cloud, {0, 1, -1}, {6, 0, 0}, {0, 0, 2});
  add_rectangle(cloud, {0, -1, -1}, {0, 0, 2}, {6, 0, 0});
  add_rectangle(cloud, {0, -1, -1}, {6, 0, 0}, {0, 2, 0});
  return cloud;
}

/// A corner of a room with a box in it: all six directions are fixed.
inline Cloud room(double spacing = 0.05) {
  Cloud cloud;
  add_rectangle(cloud, {3, -1.5, -1}, {0, 0, 2}, {0, 3, 0}, spacing);
  add_rectangle(cloud, {1, -1.5, -1}, {0, 0, 2}, {2, 0, 0}, spacing);
  add_rectangle(cloud, {1, -1.5, -1}, {2, 0, 0}, {0, 3, 0}, spacing);
  add_rectangle(cloud, {2, 0, -1}, {0, 0, 0.7}, {0, 0.8, 0}, spacing);
  add_rectangle(cloud, {2, 0, -0.3}, {0.6, 0, 0}, {0, 0.8, 0}, spacing);
  return cloud;
}

inline Cloud sphere(const Eigen::Vector3d& centre, double radius) {
  Cloud cloud;
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const double x = random.normal();
    const double y = random.normal();
    const double z = random.normal();
    const Eigen::Vector3d n = Eigen::Vector3d(x, y, z).normalized();
    cloud.points.emplace_back((centre + radius * n).cast<float>());
    cloud.normals.emplace_back(n.cast<float>());
  }
  return cloud;
}

inline Vector6d twist(double x, double y, double z, double rx, double ry, double rz) {
  Vector6d v;
  v << x, y, z, rx, ry, rz;
  return v;
}

}  // namespace lcmslam
