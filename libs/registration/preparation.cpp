#include <lcmslam/registration/preparation.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include <lcmslam/cloud/cloud_normals.hpp>
#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/registration/tangent_gradient.hpp>

namespace lcmslam {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// Two unit vectors that span the plane of a unit normal.
Eigen::Matrix<float, 3, 2> tangents(const Eigen::Vector3f& normal) {
  Eigen::Matrix<float, 3, 2> axes;
  axes.col(0) = normal.unitOrthogonal();
  axes.col(1) = normal.cross(axes.col(0));
  return axes;
}

bool needs_source_normals(const RegistrationSettings& s) {
  return s.metric == MetricKind::plane_to_plane || s.selection == SelectionKind::normal_space ||
         s.selection == SelectionKind::stable;
}

}  // namespace

void estimate_gradients(Cloud& cloud, int neighbours) {
  cloud.gradients.assign(cloud.size(), Eigen::Vector3f::Constant(nan));
  if (cloud.intensities.empty() || !cloud.has_normals()) return;
  const KdTree tree(cloud.points);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.normals[i].allFinite()) continue;
    TangentGradient gradient(cloud.normals[i]);
    for (const auto& n : tree.nearest_few(cloud.points[i], static_cast<std::size_t>(neighbours))) {
      const auto j = static_cast<std::size_t>(n.index);
      gradient.add(cloud.points[j] - cloud.points[i], cloud.intensities[j] - cloud.intensities[i]);
    }
    cloud.gradients[i] = gradient.solve();
  }
}

void mark_boundary(Cloud& cloud, int neighbours, double gap) {
  constexpr float pi = 3.14159265f;
  cloud.boundary.assign(cloud.size(), 0);
  if (!cloud.has_normals()) return;
  const KdTree tree(cloud.points);
  std::vector<float> angles;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.normals[i].allFinite()) continue;
    const auto axes = tangents(cloud.normals[i]);
    angles.clear();
    for (const auto& n : tree.nearest_few(cloud.points[i], static_cast<std::size_t>(neighbours) + 1)) {
      if (!(n.squared_distance > 0)) continue;
      const Eigen::Vector2f side =
          axes.transpose() * (cloud.points[static_cast<std::size_t>(n.index)] - cloud.points[i]);
      angles.push_back(std::atan2(side.y(), side.x()));
    }
    std::sort(angles.begin(), angles.end());
    float widest = angles.empty() ? 2 * pi : angles.front() + 2 * pi - angles.back();
    for (std::size_t k = 1; k < angles.size(); ++k) widest = std::max(widest, angles[k] - angles[k - 1]);
    cloud.boundary[i] = widest > static_cast<float>(gap) ? 1 : 0;
  }
}

Cloud prepared_target(Cloud cloud, const RegistrationSettings& s, const Eigen::Vector3d& view_point) {
  const bool colour = s.colour_scale > 0 && !cloud.intensities.empty();
  const bool normals = s.metric != MetricKind::point_to_point || s.boundary || colour;
  if (normals && !cloud.has_normals()) estimate_normals(cloud, view_point);
  if (s.boundary && cloud.boundary.empty()) mark_boundary(cloud);
  if (colour && cloud.gradients.empty()) estimate_gradients(cloud);
  return cloud;
}

Cloud prepared_source(Cloud cloud, const RegistrationSettings& s, const Eigen::Vector3d& view_point) {
  if (needs_source_normals(s) && !cloud.has_normals()) estimate_normals(cloud, view_point);
  return cloud;
}

}  // namespace lcmslam
