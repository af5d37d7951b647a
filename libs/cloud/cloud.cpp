#include <lcmslam/cloud/cloud.hpp>

#include <limits>
#include <stdexcept>
#include <string>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/cloud/voxel_index.hpp>

namespace lcmslam {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

struct VoxelSum {
  float weight = 0;
  Eigen::Vector3f point = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();
  float sigma = 0;
};

// Sums of the voxels in order of first appearance. Cloud is Cloud or ColouredCloud.
template <typename AnyCloud, typename ColourOf>
std::vector<VoxelSum> sum_voxels(const AnyCloud& cloud, double voxel_size, ColourOf colour_of) {
  if (!(voxel_size > 0))
    throw std::invalid_argument("voxel size is " + std::to_string(voxel_size) + " m, must be positive");
  const float inverse = static_cast<float>(1.0 / voxel_size);
  VoxelIndex index(cloud.size() / 2);
  std::vector<VoxelSum> sums;
  sums.reserve(cloud.size() / 2);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (!voxel_exists(p, inverse)) continue;
    const float sigma = cloud.sigmas.empty() ? 1.0f : cloud.sigmas[i];
    if (!(sigma > 0) || !std::isfinite(sigma)) continue;
    const auto slot = index.insert(voxel_key(voxel_of(p, inverse)), static_cast<std::int32_t>(sums.size()));
    if (static_cast<std::size_t>(slot) == sums.size()) sums.emplace_back();
    VoxelSum& s = sums[static_cast<std::size_t>(slot)];
    const float w = 1.0f / (sigma * sigma);
    s.weight += w;
    s.point += w * p;
    s.sigma += w * sigma;
    s.colour += w * colour_of(i);
    if (!cloud.normals.empty() && cloud.normals[i].allFinite()) s.normal += w * cloud.normals[i];
  }
  return sums;
}

// Normals that cancel out (both sides of a thin board) say nothing.
Eigen::Vector3f mean_normal(const VoxelSum& s) {
  const float length = s.normal.norm();
  if (!(length > 0.1f * s.weight)) return Eigen::Vector3f::Constant(nan);
  return s.normal / length;
}

template <typename AnyCloud>
void append_geometry(const VoxelSum& s, const AnyCloud& like, AnyCloud& cloud) {
  cloud.points.push_back(s.point / s.weight);
  if (!like.normals.empty()) cloud.normals.push_back(mean_normal(s));
  if (!like.sigmas.empty()) cloud.sigmas.push_back(s.sigma / s.weight);
}

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

void move(Cloud& cloud, const Eigen::Isometry3d& T) {
  const Eigen::Isometry3f T_float = T.cast<float>();
  for (auto& p : cloud.points) p = T_float * p;
  for (auto& n : cloud.normals) n = T_float.linear() * n;
  for (auto& g : cloud.gradients) g = T_float.linear() * g;
}

std::size_t memory_bytes(const Cloud& c) {
  return bytes_of(c.points) + bytes_of(c.normals) + bytes_of(c.sigmas) + bytes_of(c.intensities) +
         bytes_of(c.gradients) + bytes_of(c.boundary);
}

std::size_t memory_bytes(const ColouredCloud& c) {
  return bytes_of(c.points) + bytes_of(c.colours) + bytes_of(c.normals) + bytes_of(c.sigmas);
}

ColouredCloud transformed(const ColouredCloud& cloud, const Eigen::Isometry3d& T) {
  const Eigen::Isometry3f move = T.cast<float>();
  ColouredCloud moved = cloud;
  for (Eigen::Vector3f& p : moved.points) p = move * p;
  for (Eigen::Vector3f& n : moved.normals) n = move.linear() * n;
  return moved;
}

void append(const ColouredCloud& more, ColouredCloud& cloud) {
  if (more.size() == 0) return;
  if (cloud.size() > 0 &&
      (more.normals.empty() != cloud.normals.empty() || more.sigmas.empty() != cloud.sigmas.empty()))
    throw std::invalid_argument("clouds that are joined must both have normals, and sigmas, or neither");
  cloud.points.insert(cloud.points.end(), more.points.begin(), more.points.end());
  cloud.colours.insert(cloud.colours.end(), more.colours.begin(), more.colours.end());
  cloud.normals.insert(cloud.normals.end(), more.normals.begin(), more.normals.end());
  cloud.sigmas.insert(cloud.sigmas.end(), more.sigmas.begin(), more.sigmas.end());
}

Cloud geometry_of(const ColouredCloud& cloud, const Eigen::Isometry3d& T) {
  Cloud geometry(cloud.points, cloud.normals, cloud.sigmas);
  move(geometry, T);
  return geometry;
}

std::vector<float> intensities_of(const ColouredCloud& cloud) {
  std::vector<float> intensities;
  intensities.reserve(cloud.size());
  for (const cv::Vec3b& bgr : cloud.colours)
    intensities.push_back((0.114f * bgr[0] + 0.587f * bgr[1] + 0.299f * bgr[2]) / 255);
  return intensities;
}

Cloud transformed(const Cloud& cloud, const Eigen::Isometry3d& T) {
  Cloud result = cloud;
  move(result, T);
  return result;
}

Cloud voxel_filtered(const Cloud& cloud, double voxel_size) {
  const bool grey = !cloud.intensities.empty();
  const auto intensity_of = [&](std::size_t i) -> Eigen::Vector3f {
    return Eigen::Vector3f(grey ? cloud.intensities[i] : 0, 0, 0);
  };
  Cloud result;
  for (const VoxelSum& s : sum_voxels(cloud, voxel_size, intensity_of)) {
    append_geometry(s, cloud, result);
    if (grey) result.intensities.push_back(s.colour.x() / s.weight);
  }
  return result;
}

ColouredCloud voxel_filtered(const ColouredCloud& cloud, double voxel_size) {
  const auto colour_of = [&](std::size_t i) -> Eigen::Vector3f {
    const cv::Vec3b& c = cloud.colours[i];
    return Eigen::Vector3f(c[0], c[1], c[2]);
  };
  const std::vector<VoxelSum> sums = sum_voxels(cloud, voxel_size, colour_of);
  ColouredCloud result;  // kept for long: no more memory than it needs
  result.points.reserve(sums.size());
  result.colours.reserve(sums.size());
  if (!cloud.normals.empty()) result.normals.reserve(sums.size());
  if (!cloud.sigmas.empty()) result.sigmas.reserve(sums.size());
  for (const VoxelSum& s : sums) {
    append_geometry(s, cloud, result);
    const Eigen::Vector3f c = s.colour / s.weight;
    result.colours.emplace_back(cv::saturate_cast<uchar>(c.x()), cv::saturate_cast<uchar>(c.y()),
                                cv::saturate_cast<uchar>(c.z()));
  }
  return result;
}

}  // namespace lcmslam
