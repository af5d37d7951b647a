#pragma once
// Which keyframes stand where, and whether the graph has moved any of them so far that what was made at its
// old pose must be made anew.

#include <map>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

class MovedKeyframes {
 public:
  /// `distance` in m, `angle` in rad: what is below both has not moved.
  MovedKeyframes(double distance, double angle) : distance_(distance), angle_(angle) {}

  /// T_map_camera: where the keyframe stands, and what is made of it is made there.
  void add(int keyframe, const Eigen::Isometry3d& T_map_camera) {
    keyframes_[keyframe] = {T_map_camera, T_map_camera};
  }
  void forget(int keyframe) { keyframes_.erase(keyframe); }

  /// Where keyframes stand now; those that were not added are left out.
  void correct(const std::map<int, Eigen::Isometry3d>& T_map_camera) {
    for (const auto& [id, T] : T_map_camera)
      if (const auto found = keyframes_.find(id); found != keyframes_.end()) found->second.wanted = T;
  }

  /// Whether one of them moved too far.
  bool due() const {
    for (const auto& [id, k] : keyframes_) {
      const Eigen::Isometry3d moved = k.made.inverse() * k.wanted;
      if (moved.translation().norm() > distance_ || so3_log(moved.linear()).norm() > angle_) return true;
    }
    return false;
  }

  /// All that moved, however little, T_map_camera by keyframe; they count as made there from now on.
  std::map<int, Eigen::Isometry3d> take() {
    std::map<int, Eigen::Isometry3d> moved;
    for (auto& [id, k] : keyframes_) {
      if (k.made.isApprox(k.wanted, 1e-9)) continue;
      moved[id] = k.made = k.wanted;
    }
    return moved;
  }

 private:
  struct Keyframe {
    Eigen::Isometry3d made, wanted;
  };
  double distance_, angle_;
  std::map<int, Keyframe> keyframes_;
};

}  // namespace lcmslam
