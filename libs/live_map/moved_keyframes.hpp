#pragma once
// Which keyframes stand where, and whether the graph has moved any of them so far that what was made at its
// old pose must be made anew, or given some up, without which it must be. Where the graph of a large map
// bends all the time, that takes a bounded share of the frames' time.

#include <algorithm>
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
  /// The same, and what is made of the others is to be made without it.
  void give_up(int keyframe) {
    forget(keyframe);
    given_up_ = true;
  }

  /// Where keyframes stand now; those that were not added are left out.
  void correct(const std::map<int, Eigen::Isometry3d>& T_map_camera) {
    for (const auto& [id, T] : T_map_camera)
      if (const auto found = keyframes_.find(id); found != keyframes_.end()) found->second.wanted = T;
    moved_ =
        std::any_of(keyframes_.begin(), keyframes_.end(), [&](const auto& k) { return is_far(k.second); });
  }
  /// A frame came, keyframe or not.
  void frame() { ++frames_; }

  /// Whether one of them moved too far, or was given up.
  bool moved() const { return moved_ || given_up_; }
  /// The same, and enough frames came since take().
  bool due() const { return moved() && made_a_frame * frames_ >= keyframes_.size(); }

  /// All that moved, however little, T_map_camera by keyframe; they count as made there from now on.
  std::map<int, Eigen::Isometry3d> take() {
    std::map<int, Eigen::Isometry3d> moved;
    moved_ = given_up_ = false;
    frames_ = 0;
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
  static constexpr std::size_t made_a_frame = 4;  // keyframes, a millisecond or two each
  bool is_far(const Keyframe& k) const {
    const Eigen::Isometry3d way = k.made.inverse() * k.wanted;
    return way.translation().norm() > distance_ || so3_log(way.linear()).norm() > angle_;
  }

  bool moved_ = false, given_up_ = false;
  std::size_t frames_ = 1'000'000'000;  // since take(); at first nothing is to be waited for
  double distance_, angle_;
  std::map<int, Keyframe> keyframes_;
};

}  // namespace lcmslam
