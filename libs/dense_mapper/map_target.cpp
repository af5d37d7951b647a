#include <lcmslam/dense_mapper/map_target.hpp>

#include <utility>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/preparation.hpp>
#include <lcmslam/registration/projective_target.hpp>

namespace lcmslam {
namespace {

/// Finds what a target made of the map's surfels finds, and tells which are young, as the map knows.
class WithAges : public Target {
 public:
  WithAges(const VoxelMap& map, std::unique_ptr<Target> target) : map_(map), target_(std::move(target)) {}

  bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const override {
    return target_->find(point, max_distance, found) && with_age(found);
  }
  bool find_along(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float max_distance,
                  TargetPoint& found) const override {
    return target_->find_along(point, normal, max_distance, found) && with_age(found);
  }
  bool finds_nearest() const override { return target_->finds_nearest(); }
  std::size_t size() const override { return target_->size(); }

 private:
  bool with_age(TargetPoint& found) const {
    constexpr float the_same = 1e-5f;  // m
    TargetPoint surfel;
    found.young = map_.find(found.point, the_same, surfel) && surfel.young;
    return true;
  }

  const VoxelMap& map_;
  std::unique_ptr<Target> target_;
};

std::unique_ptr<Target> make_target(Cloud cloud, CorrespondenceKind kind,
                                    const Eigen::Isometry3d& T_world_camera) {
  if (kind == CorrespondenceKind::projective)
    return std::make_unique<ProjectiveTarget>(cloud, T_world_camera);
  if (kind == CorrespondenceKind::normal_shooting)
    return std::make_unique<NormalShootingTarget>(std::move(cloud));
  return std::make_unique<KdTreeTarget>(std::move(cloud));
}

}  // namespace

std::string to_string(CorrespondenceKind kind) {
  static const char* const names[] = {"voxel map", "k-d tree", "projective", "normal shooting"};
  return names[static_cast<std::size_t>(kind)];
}

MapTarget::MapTarget(const VoxelMap& map, CorrespondenceKind kind, double radius,
                     const RegistrationSettings& prepared_for)
    : map_(&map), kind_(kind), radius_(radius), prepared_for_(prepared_for) {}

const Target& MapTarget::from(const Eigen::Isometry3d& T_world_camera) {
  if (kind_ == CorrespondenceKind::voxel_map) return *map_;
  if (!still_good(T_world_camera)) {
    Cloud nearby = prepared_target(map_->partners_around(T_world_camera.translation(), radius_),
                                   prepared_for_, T_world_camera.translation());
    target_ = std::make_unique<WithAges>(*map_, make_target(std::move(nearby), kind_, T_world_camera));
    revision_ = map_->revision();
    T_world_camera_ = T_world_camera;
  }
  return *target_;
}

// A ball looks the same from everywhere inside it; a projection does not: rays to points a metre away
// may turn by about a cell of the grid before partners are sought in the wrong place.
bool MapTarget::still_good(const Eigen::Isometry3d& T_world_camera) const {
  if (!target_ || revision_ != map_->revision()) return false;
  const Eigen::Isometry3d moved = T_world_camera_.inverse() * T_world_camera;
  if (kind_ == CorrespondenceKind::projective)
    return moved.translation().norm() < 0.05 && rotation_angle(moved) < 0.1;
  return moved.translation().norm() < 0.1 * radius_;
}

}  // namespace lcmslam
