#pragma once
// What registration searches for partners: the map itself, or a k-d tree or a projection of the part
// of it around the camera, made anew when the map has grown or the camera has moved on.

#include <memory>
#include <string>

#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

enum class CorrespondenceKind { voxel_map, kd_tree, projective, normal_shooting };
inline constexpr Choice<CorrespondenceKind> correspondence_names[] = {
    {"voxel_map", CorrespondenceKind::voxel_map},
    {"kd_tree", CorrespondenceKind::kd_tree},
    {"projective", CorrespondenceKind::projective},
    {"normal_shooting", CorrespondenceKind::normal_shooting}};
std::string to_string(CorrespondenceKind kind);

class MapTarget {
 public:
  /// `map` must outlive the view or the next one that is shown. `radius` (m): the part around the camera that
  /// is looked at.
  /// `prepared_for`: what metric and rejectors ask of that part (registration/preparation.hpp); the map
  /// itself knows no boundaries.
  MapTarget(const VoxelMap& map, CorrespondenceKind kind, double radius,
            const RegistrationSettings& prepared_for = {});

  /// Another map, with another revision.
  void show(const VoxelMap& map) { map_ = &map; }

  /// As seen from about T_world_camera. Valid until the next call and the map's next insertion.
  const Target& from(const Eigen::Isometry3d& T_world_camera);

 private:
  bool still_good(const Eigen::Isometry3d& T_world_camera) const;

  const VoxelMap* map_;
  CorrespondenceKind kind_;
  double radius_;
  RegistrationSettings prepared_for_;
  std::unique_ptr<Target> target_;
  std::int32_t revision_ = -1;  // of the map that target_ shows
  Eigen::Isometry3d T_world_camera_ = Eigen::Isometry3d::Identity();
};

}  // namespace lcmslam
