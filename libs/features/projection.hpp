#pragma once
// Where a predicted camera should see a mapped point, and how surely.

#include <Eigen/Core>
#include <optional>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

struct PredictedPose {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< body frame (right perturbation), metres and radians
};

/// A landmark: `id` in the DescriptorIndex.
struct MapPoint {
  int id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, world
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2, world
};

struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 6> by_pose;   ///< d pixel / d xi, T_world_camera * exp(xi)
  Eigen::Matrix<double, 2, 3> by_point;  ///< d pixel / d position
};

/// Pinhole of the frame's fx, fy, cx, cy. With p = R' (position - t) in the camera frame,
///   pixel = (fx x / z + cx, fy y / z + cy),
///   d p / d xi = [-I, hat(p)],  d p / d position = R'
/// (Sola, Deray & Atchuthan 2018, "A micro Lie theory", eq. 191 with the inverse's Jacobian). Nothing for
/// points less than 0.1 m in front of the camera, or not finite.
std::optional<Projection> project(const MapPoint& point, const Eigen::Isometry3d& T_world_camera,
                                  const FeatureFrame& frame);

/// 2x2 covariance of the innovation (measured pixel less predicted one): by_pose P by_pose' + by_point C
/// by_point' + pixel_sigma^2 I (Davison et al. 2007, "MonoSLAM", section 3.5: the search region).
Eigen::Matrix2d innovation_covariance(const Projection& projection, const MapPoint& point,
                                      const PredictedPose& pose, const FeatureFrame& frame);

}  // namespace lcmslam
