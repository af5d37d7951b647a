#pragma once
// Averages coloured points that fall into the same cell of a regular grid.

#include <cstdint>
#include <vector>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// One map of many clouds: every point counts alike, sums are double, and cells come sorted by their integer
/// coordinates (z, then y, then x), so that the result depends on the clouds and their order only.
/// voxel_filtered (cloud.hpp) reduces one cloud instead: it weighs points by their noise and is fast enough
/// for every frame.
class VoxelAverage {
 public:
  /// Edge length of the cells in m; throws std::invalid_argument unless positive and finite.
  explicit VoxelAverage(double resolution);

  /// Adds a cloud, moved by T_world_cloud. Points that are not finite or farther than 2^20 cells from
  /// the origin are left out.
  void add(const ColouredCloud& cloud,
           const Eigen::Isometry3d& T_world_cloud = Eigen::Isometry3d::Identity());

  /// Mean position and colour of each cell; normals (unit, NaN where no point had one) when any
  /// cloud had normals. No sigmas.
  ColouredCloud result() const;

 private:
  struct Voxel {
    std::uint64_t key = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    Eigen::Vector3d colour = Eigen::Vector3d::Zero();
    double count = 0;
  };
  using Run = std::vector<Voxel>;  ///< sorted by key, keys unique

  static void accumulate(Voxel& sum, const Voxel& other);
  static Run merge(const Run& a, const Run& b);

  double resolution_;
  bool has_normals_ = false;
  std::vector<Run> runs_;  ///< of falling size, as in merge sort: adding n clouds costs n log n
};

}  // namespace lcmslam
