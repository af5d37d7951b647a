#pragma once
// Whether a body fits where it is, or on its way, against distance fields: that of the kept map and that of
// what the newest frame shows, so that whoever steps in the way counts at once.
//
// A body collides when the centre of an occupied cell is within half a cell of it. Bodies are divided into
// parts until the distance at a part's middle decides; answers err by a cell at most, and then say that the
// body collides.

#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/map_layers/distance_field.hpp>

namespace lcmslam {

struct Sphere {
  Eigen::Vector3d centre;  ///< m
  double radius;           ///< m
};

/// All within `radius` of the line from one end to the other.
struct Capsule {
  Eigen::Vector3d from, to;  ///< m
  double radius;             ///< m
};

struct Box {
  Eigen::Isometry3d T_map_box = Eigen::Isometry3d::Identity();  ///< of its middle
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();          ///< m, from the middle to the faces
};

/// Space that nobody has seen counts as free: ask the occupancy grid for that.
class CollisionChecker {
 public:
  /// The fields must outlive it and not change meanwhile; all of one cell size (std::invalid_argument).
  explicit CollisionChecker(std::vector<const DistanceField*> fields);

  /// m from the point to the nearest occupied cell's centre; at most the smallest of the fields' truncations
  /// when none is nearer.
  double distance(const Eigen::Vector3d& point) const;

  bool collides(const Sphere& sphere) const;
  bool collides(const Capsule& capsule) const;
  bool collides(const Box& box) const;

 private:
  template <class Outside>
  bool part_collides(const Box& part, const Outside& outside) const;
  struct Bounds {
    double least, most;
  };
  Bounds bounds(const Eigen::Vector3d& point) const;

  std::vector<const DistanceField*> fields_;
  double cell_size_ = 0;
};

}  // namespace lcmslam
