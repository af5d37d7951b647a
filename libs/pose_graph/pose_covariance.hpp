#pragma once
// How wrong the poses of a graph may be, as seen from the first one: their marginal covariances,
//
//   of pose i: block (i, i) of H^-1 + G G^T   (graph_marginals.hpp)
//
// R is what an edge errs by, which is less than what it is weighed by: weights are cautious, because one edge
// that is wrong bends the map (PoseGraphSettings::edge_error, ground_error); by how much it is, the graph
// itself tells (error_factors.hpp). The errors b that edges share (PoseGraphSettings::turn_scale all of
// them; motion_scale and curvature those of a stretch of the way) do not average out as their own do, and
// only a map that closes resists them. What a wrong mount makes of the ground is kept apart, because the
// robot's pose errs by that mount as well (mount_error.hpp).

#include <vector>

#include <lcmslam/pose_graph/error_factors.hpp>
#include <lcmslam/pose_graph/graph_marginals.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// Of T exp(xi), T a camera's: m, rad, body frame.
struct PoseError {
  Matrix6d own = Matrix6d::Zero();       ///< covariance of xi, but for:
  Matrix6d by_mount = Matrix6d::Zero();  ///< xi for one sigma of each part of the mount's error

  Matrix6d covariance() const { return own + by_mount * by_mount.transpose(); }
};

/// By node; the first one's is zero. Nothing when the edges do not tie all nodes to the first.
std::vector<PoseError> pose_errors(const PoseGraph& graph, const PoseGraphSettings& settings,
                                   const ErrorFactors& factors = {},
                                   EdgeErrors edges = EdgeErrors::independent);

/// Of the robot's pose T_world_camera T_robot_camera^-1, seen from its first one: m, rad, robot's body frame.
/// `error`: of T_world_camera; T_first_now: from the first camera; `mount_sigmas`: of the mount's error.
Matrix6d robot_covariance(const PoseError& error, const Eigen::Isometry3d& T_first_now,
                          const Eigen::Isometry3d& T_robot_camera, const Vector6d& mount_sigmas);

/// After another step of the camera.
PoseError carried_along(const PoseError& error, const UncertainTransform& step);
/// After its robot was found to stand on the floor of `ground`'s node 0; T_first_now: from the first camera.
PoseError on_ground(const PoseError& error, const Eigen::Isometry3d& T_first_now,
                    const GroundConstraint& ground, const PoseGraphSettings& settings,
                    const ErrorFactors& factors);

}  // namespace lcmslam
