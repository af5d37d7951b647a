#pragma once
// A cloud as a target of each kind that the dense mapper knows.

#include <memory>

#include <lcmslam/dense_mapper/map_target.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/projective_target.hpp>

namespace lcmslam {

/// `T_target_camera` is where a projection looks at it from.
inline std::unique_ptr<Target> make_target(
    const Cloud& cloud, CorrespondenceKind kind,
    const Eigen::Isometry3d& T_target_camera = Eigen::Isometry3d::Identity()) {
  switch (kind) {
    case CorrespondenceKind::projective:
      return std::make_unique<ProjectiveTarget>(cloud, T_target_camera);
    case CorrespondenceKind::normal_shooting:
      return std::make_unique<NormalShootingTarget>(cloud);
    case CorrespondenceKind::voxel_map: {
      auto map = std::make_unique<VoxelMap>();
      map->insert(cloud, T_target_camera);
      return map;
    }
    case CorrespondenceKind::kd_tree:
      break;
  }
  return std::make_unique<KdTreeTarget>(cloud);
}

}  // namespace lcmslam
