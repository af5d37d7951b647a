#pragma once
// Clouds as targets, their points found by a k-d tree.

#include <utility>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/registration/target.hpp>

namespace lcmslam {

/// A cloud as a target.
class KdTreeTarget : public Target {
 public:
  explicit KdTreeTarget(Cloud cloud) : cloud_(std::move(cloud)), tree_(cloud_.points) {}
  bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const override;
  bool finds_nearest() const override { return true; }
  std::size_t size() const override { return tree_.size(); }

 protected:
  Cloud cloud_;
  KdTree tree_;
};

/// Normal shooting (Chen and Medioni 1991): the partner of a point lies along its normal. Points without a
/// normal take the nearest.
class NormalShootingTarget : public KdTreeTarget {
 public:
  using KdTreeTarget::KdTreeTarget;
  bool finds_nearest() const override { return false; }
  bool find_along(const Eigen::Vector3f& point, const Eigen::Vector3f& normal, float max_distance,
                  TargetPoint& found) const override;
};

}  // namespace lcmslam
