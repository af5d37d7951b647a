#pragma once
// What a cloud is registered against: anything that finds a partner for a point. A k-d tree, a
// projected point image and the voxel map are targets; they differ in cost and in basin.

#include <Eigen/Core>

namespace lcmslam {

struct TargetPoint {
  Eigen::Vector3f point;   ///< m, target frame
  Eigen::Vector3f normal;  ///< unit, NaN where unknown
  float sigma = 0;         ///< m, 0 where unknown
};

class Target {
 public:
  virtual ~Target() = default;
  /// Partner of a point of the target frame (m) at most max_distance away; false when there is
  /// none or the point is not finite. Safe to call from several threads.
  virtual bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const = 0;
  /// Number of points; a target without any finds nothing.
  virtual std::size_t size() const = 0;
};

}  // namespace lcmslam
