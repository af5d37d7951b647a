#include <lcmslam/cloud/voxel_average.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <lcmslam/cloud/coloured_cloud.hpp>

namespace lcmslam {
namespace {

constexpr double half_range = 1 << 20;  // cells on either side of the origin, 21 bits an axis

/// Packed cell coordinates, z in the highest bits; false when the point has no cell.
bool voxel_key(const Eigen::Vector3d& point, double resolution, std::uint64_t& key) {
  key = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const double cell = std::floor(point[axis] / resolution);
    if (!(cell >= -half_range && cell < half_range)) return false;  // also when not finite
    key = key << 21 | static_cast<std::uint64_t>(cell + half_range);
  }
  return true;
}

}  // namespace

VoxelAverage::VoxelAverage(double resolution) : resolution_(resolution) {
  if (!(resolution > 0) || !std::isfinite(resolution))
    throw std::invalid_argument("voxel resolution " + std::to_string(resolution) +
                                " m: must be positive and finite");
}

void VoxelAverage::accumulate(Voxel& sum, const Voxel& other) {
  sum.position += other.position;
  sum.normal += other.normal;
  sum.colour += other.colour;
  sum.count += other.count;
}

VoxelAverage::Run VoxelAverage::merge(const Run& a, const Run& b) {
  Run merged;
  merged.reserve(a.size() + b.size());
  auto left = a.begin();
  auto right = b.begin();
  while (left != a.end() && right != b.end()) {
    if (left->key < right->key) {
      merged.push_back(*left++);
    } else if (right->key < left->key) {
      merged.push_back(*right++);
    } else {
      merged.push_back(*left++);
      accumulate(merged.back(), *right++);
    }
  }
  merged.insert(merged.end(), left, a.end());
  merged.insert(merged.end(), right, b.end());
  return merged;
}

void VoxelAverage::add(const ColouredCloud& cloud, const Eigen::Isometry3d& T_world_cloud) {
  const bool has_normals = cloud.normals.size() == cloud.size() && cloud.size() > 0;
  has_normals_ = has_normals_ || has_normals;
  Run points;
  points.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Voxel voxel;
    voxel.position = T_world_cloud * cloud.points[i].cast<double>();
    if (!voxel_key(voxel.position, resolution_, voxel.key)) continue;
    if (has_normals && cloud.normals[i].allFinite())
      voxel.normal = T_world_cloud.linear() * cloud.normals[i].cast<double>();
    const cv::Vec3b& colour = cloud.colours[i];
    voxel.colour = {double(colour[0]), double(colour[1]), double(colour[2])};
    voxel.count = 1;
    points.push_back(voxel);
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const Voxel& a, const Voxel& b) { return a.key < b.key; });

  Run run;
  for (const Voxel& point : points) {
    if (!run.empty() && run.back().key == point.key)
      accumulate(run.back(), point);
    else
      run.push_back(point);
  }
  run.shrink_to_fit();
  runs_.push_back(std::move(run));
  while (runs_.size() >= 2 && runs_[runs_.size() - 2].size() < 2 * runs_.back().size()) {
    Run merged = merge(runs_[runs_.size() - 2], runs_.back());
    runs_.pop_back();
    runs_.back() = std::move(merged);
  }
}

ColouredCloud VoxelAverage::result() const {
  Run all;
  for (auto run = runs_.rbegin(); run != runs_.rend(); ++run) all = merge(*run, all);
  ColouredCloud cloud;
  for (const Voxel& voxel : all) {
    const Eigen::Vector3d colour = voxel.colour / voxel.count;
    cloud.points.push_back((voxel.position / voxel.count).cast<float>());
    cloud.colours.emplace_back(cv::saturate_cast<uchar>(colour[0]), cv::saturate_cast<uchar>(colour[1]),
                               cv::saturate_cast<uchar>(colour[2]));
    if (!has_normals_) continue;
    // Opposite normals (the two sides of a thin door) cancel out: then none is known.
    const double length = voxel.normal.norm();
    const Eigen::Vector3f unknown = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    cloud.normals.push_back(length > 1e-6 ? (voxel.normal / length).cast<float>().eval() : unknown);
  }
  return cloud;
}

}  // namespace lcmslam
