#include <lcmslam/dense_mapper/companion.hpp>

#include <algorithm>

#include <lcmslam/dense_mapper/contradiction.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

Companion::Companion() = default;
Companion::~Companion() = default;

void Companion::begin(const Cloud& cloud) {
  seen_ = std::make_unique<VoxelMap>();
  seen_->insert(cloud, Eigen::Isometry3d::Identity());
  T_seen_now_.setIdentity();
}

void Companion::end() {
  seen_.reset();
}

void Companion::observe(const Cloud& cloud, const Motion& motion) {
  constexpr double far = 0.3;         // m, rad: what is compared then is seen anew
  constexpr double enough = 50;       // points that tell
  constexpr double most_stand = 0.2;  // share of them, of what passes
  if (!there()) return;
  T_seen_now_ = T_seen_now_ * motion.T_from_to;
  const Standing told = compare(cloud, Eigen::Isometry3d::Identity(), T_seen_now_, *seen_);
  const double tell = told.stands + told.moved;
  if (tell > enough && told.stands < most_stand * tell)
    end();
  else if (T_seen_now_.translation().norm() > far || rotation_angle(T_seen_now_) > far)
    begin(cloud);
}

}  // namespace lcmslam
