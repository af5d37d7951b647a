#pragma once
// Where frames lie in each other, as /tf and /tf_static say.

#include <map>
#include <optional>
#include <string>

#include <lcmslam/ros/messages.hpp>

namespace lcmslam::ros {

class TransformTree {
 public:
  /// The first word about a frame stands; later ones are compared with it.
  void add(const Transform& transform);

  bool has(const std::string& frame) const;

  struct Found {
    Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
    double moved = 0, turned = 0;  ///< m and rad by which its parts changed at most, later
    bool is_still() const { return moved < 1e-3 && turned < 2e-3; }  ///< but for rounding
  };
  /// Nothing where no way leads from one to the other.
  std::optional<Found> find(const std::string& a, const std::string& b) const;

 private:
  struct Edge {
    std::string parent;
    Eigen::Isometry3d T_parent_child;
    double moved = 0, turned = 0;
  };
  /// From the frame to its root: each frame on the way, and the frame in it.
  std::map<std::string, Found> way_up(std::string frame) const;

  std::map<std::string, Edge> edges_;  // by child
};

}  // namespace lcmslam::ros
