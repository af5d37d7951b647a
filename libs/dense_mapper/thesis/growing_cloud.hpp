#pragma once
// The thesis's target (end of section 3.3): each registered cloud joins it, but for points that are there
// already.

#include <memory>
#include <vector>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/registration/target.hpp>

namespace lcmslam {

/// Exact nearest neighbours in a cloud that grows: k-d trees of doubling sizes (Bentley and Saxe 1980), so
/// that a point is built into a tree only a logarithmic number of times. Nothing is ever forgotten.
class GrowingCloud : public Target {
 public:
  /// Points nearer than `merge_distance` (m) to one that is there are the same point. Throws
  /// std::invalid_argument when it is negative or no number.
  explicit GrowingCloud(double merge_distance);

  /// A cloud in the target's frame. Its own points are not compared with each other. Returns how many joined.
  std::size_t add(const Cloud& cloud);

  bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const override;
  std::size_t size() const override { return cloud_.size(); }
  std::size_t memory_bytes() const;
  /// The last `count` points that joined; NaN normals and sigmas of 0 where unknown.
  Cloud newest(std::size_t count) const;

 private:
  struct Part {
    std::size_t begin, end;  // of cloud_
    KdTree tree;
  };
  void build(std::size_t begin);
  std::int32_t nearest(const Eigen::Vector3f& point, float max_distance) const;  // -1: none

  float merge_distance_;
  Cloud cloud_;  // normals and sigmas for every point (NaN and 0 where unknown)
  std::vector<Part> parts_;
};

}  // namespace lcmslam
