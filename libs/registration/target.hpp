#pragma once
// What a cloud is registered against: anything that finds a partner for a point. A k-d tree, a
// projected point image and the voxel map are targets; they differ in cost and in basin.

#include <Eigen/Core>
#include <limits>

namespace lcmslam {

struct TargetPoint {
  static constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
  Eigen::Vector3f point;                                          ///< m, target frame
  Eigen::Vector3f normal;                                         ///< unit, NaN where unknown
  float sigma = 0;                                                ///< m, 0 where unknown
  float intensity = unknown;                                      ///< 0..1
  Eigen::Vector3f gradient = Eigen::Vector3f::Constant(unknown);  ///< of the intensity, 1/m, target frame
  bool boundary = false;                                          ///< the surface ends here
  bool young = false;  ///< it has not stood there for long, as far as anybody knows
};

class Target {
 public:
  virtual ~Target() = default;
  /// Partner of a point of the target frame (m) at most max_distance away; false when there is
  /// none or the point is not finite. Safe to call from several threads.
  virtual bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const = 0;
  /// The same for a point with its normal (unit, target frame; NaN where unknown). Most targets ignore it.
  virtual bool find_along(const Eigen::Vector3f& point, const Eigen::Vector3f& /*normal*/, float max_distance,
                          TargetPoint& found) const {
    return find(point, max_distance, found);
  }
  /// Partners are the nearest points: looked for within the distance of any point of the target, they are the
  /// same, and sooner found.
  virtual bool finds_nearest() const { return false; }
  /// For those: the same as find(), and `others`, the distance (m) that all other points of the target have
  /// at least; all points, where there is no partner. 0: nobody knows.
  virtual bool find_nearest(const Eigen::Vector3f& point, float max_distance, TargetPoint& found,
                            float& others) const {
    others = 0;
    return find(point, max_distance, found);
  }
  /// Number of points; a target without any finds nothing.
  virtual std::size_t size() const = 0;
};

}  // namespace lcmslam
