#include <lcmslam/pose_graph/pose_covariance.hpp>

#include <Eigen/Cholesky>

#include <lcmslam/geometry/mount_error.hpp>

namespace lcmslam {

std::vector<PoseError> pose_errors(const PoseGraph& graph, const PoseGraphSettings& settings,
                                   const ErrorFactors& factors, EdgeErrors edges) {
  std::vector<PoseError> errors(graph.poses.size());
  if (graph.poses.size() < 2) return errors;
  const auto marginals = GraphMarginals::of(graph, settings, factors, edges);
  if (!marginals) return {};
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const auto node = static_cast<int>(i);
    const GraphMarginals::Shared shared = marginals->shared(node);
    errors[i].own = marginals->block(node, node) + shared.by_edges * shared.by_edges.transpose();
    errors[i].by_mount = shared.by_mount;
  }
  return errors;
}

Matrix6d robot_covariance(const PoseError& error, const Eigen::Isometry3d& T_first_now,
                          const Eigen::Isometry3d& T_robot_camera, const Vector6d& mount_sigmas) {
  const Matrix6d A = adjoint(T_robot_camera);
  return A * error.own * A.transpose() +
         mount_error(T_first_now, T_robot_camera, mount_sigmas, error.by_mount);
}

PoseError carried_along(const PoseError& error, const UncertainTransform& step) {
  const UncertainTransform before{Eigen::Isometry3d::Identity(), error.own};
  return {(before * step).covariance, adjoint(step.T.inverse()) * error.by_mount};
}

// Kalman's step: the mount's error is no part of what the gain weighs, but what the ground tells holds it.
PoseError on_ground(const PoseError& error, const Eigen::Isometry3d& T_first_now,
                    const GroundConstraint& ground, const PoseGraphSettings& settings,
                    const ErrorFactors& factors) {
  const FloorJacobian A = floor_jacobian(ground);
  const Eigen::Matrix<double, 6, 3> PA = error.own * A.transpose();
  Eigen::Matrix3d S = A * PA;
  S.diagonal() += ground_error(ground, 0, settings, factors).cwiseAbs2();
  const Eigen::Matrix<double, 6, 3> K = S.ldlt().solve(PA.transpose()).transpose();
  const Matrix6d told = mount_lever(T_first_now) * ground.mount_sigmas.asDiagonal();
  return {error.own - K * PA.transpose(), error.by_mount - K * A * (error.by_mount - told)};
}

}  // namespace lcmslam
