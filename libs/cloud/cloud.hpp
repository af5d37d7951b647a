#pragma once
// Clouds as registration uses them, and their reduction by voxels.

#include <cstdint>
#include <utility>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Points with what is known of them. All vectors have the same length, but all except the points may be
/// empty.
struct Cloud {
  Cloud() = default;
  explicit Cloud(std::vector<Eigen::Vector3f> points_, std::vector<Eigen::Vector3f> normals_ = {},
                 std::vector<float> sigmas_ = {})
      : points(std::move(points_)), normals(std::move(normals_)), sigmas(std::move(sigmas_)) {}

  std::vector<Eigen::Vector3f> points;   ///< m
  std::vector<Eigen::Vector3f> normals;  ///< unit; NaN where unknown
  std::vector<float> sigmas;             ///< m, standard deviation of a point
  std::vector<float> intensities;        ///< 0..1, NaN where unknown
  // As a target alone (registration/preparation.hpp):
  std::vector<Eigen::Vector3f> gradients;  ///< of the intensity in the tangent plane, 1/m, NaN where unknown
  std::vector<std::uint8_t> boundary;      ///< 1 where the surface ends
  std::size_t size() const { return points.size(); }
  bool has_normals() const { return !normals.empty(); }
};

/// Bytes of a cloud's points and what is known of them.
std::size_t memory_bytes(const Cloud& cloud);
std::size_t memory_bytes(const ColouredCloud& cloud);

/// The coloured cloud without its colours, points and normals moved by T.
Cloud geometry_of(const ColouredCloud& cloud, const Eigen::Isometry3d& T = Eigen::Isometry3d::Identity());

/// Grey values of a coloured cloud, 0..1 (Rec. 601 luma).
std::vector<float> intensities_of(const ColouredCloud& cloud);

void move(Cloud& cloud, const Eigen::Isometry3d& T);
Cloud transformed(const Cloud& cloud, const Eigen::Isometry3d& T);

ColouredCloud transformed(const ColouredCloud& cloud, const Eigen::Isometry3d& T);
/// Adds the points of `more`. Throws std::invalid_argument where one of them has normals or sigmas and the
/// other has points without.
void append(const ColouredCloud& more, ColouredCloud& cloud);

/// The points whose index `keep` accepts, in their order.
template <class Keep>
Cloud kept_points(const Cloud& cloud, const Keep& keep) {
  Cloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!keep(i)) continue;
    kept.points.push_back(cloud.points[i]);
    if (cloud.has_normals()) kept.normals.push_back(cloud.normals[i]);
    if (!cloud.sigmas.empty()) kept.sigmas.push_back(cloud.sigmas[i]);
    if (!cloud.intensities.empty()) kept.intensities.push_back(cloud.intensities[i]);
    if (!cloud.gradients.empty()) kept.gradients.push_back(cloud.gradients[i]);
    if (!cloud.boundary.empty()) kept.boundary.push_back(cloud.boundary[i]);
  }
  return kept;
}

template <class Keep>
ColouredCloud kept_points(const ColouredCloud& cloud, const Keep& keep) {
  ColouredCloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!keep(i)) continue;
    kept.points.push_back(cloud.points[i]);
    kept.colours.push_back(cloud.colours[i]);
    if (!cloud.normals.empty()) kept.normals.push_back(cloud.normals[i]);
    if (!cloud.sigmas.empty()) kept.sigmas.push_back(cloud.sigmas[i]);
  }
  return kept;
}

/// One point for each voxel: the mean weighted by 1/sigma^2, the mean normal (NaN when none is
/// known), the mean sigma (neighbouring pixels share their errors) and the mean intensity. Order of first
/// appearance; points that are not finite are left out. Throws std::invalid_argument unless the size is
/// positive. For one cloud, as every frame needs it; VoxelAverage (voxel_average.hpp) joins many clouds to a
/// map, in which all points count alike.
Cloud voxel_filtered(const Cloud& cloud, double voxel_size);

/// The same for coloured clouds; colours are averaged.
ColouredCloud voxel_filtered(const ColouredCloud& cloud, double voxel_size);

}  // namespace lcmslam
