#pragma once
// Transforms that know their error.

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// A transform with its covariance (right perturbation).
struct UncertainTransform {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};

/// a, then b; errors independent. First order (Barfoot and Furgale 2014).
UncertainTransform operator*(const UncertainTransform& a, const UncertainTransform& b);
UncertainTransform inverse(const UncertainTransform& a);
/// Mahalanobis distance of T from the identity.
double distance_from_identity(const UncertainTransform& a);

}  // namespace lcmslam
