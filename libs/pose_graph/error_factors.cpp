#include <lcmslam/pose_graph/error_factors.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include <lcmslam/pose_graph/graph_marginals.hpp>

namespace lcmslam {
namespace {

/// Measurements of one kind.
struct Component {
  double squares = 0, redundancy = 0;

  double factor(double stated) const { return std::sqrt((stated + squares) / (stated + redundancy)); }
};

// It is weighed as all others are, and errs by what odometry says.
bool is_odometrys(const GraphEdge& edge) {
  return edge.expected_share < 1;
}

int measured_directions(const GraphEdge& edge) {
  constexpr double unknown = 1;  // m^2, rad^2
  const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(edge.T_from_to.covariance, Eigen::EigenvaluesOnly);
  return static_cast<int>((axes.eigenvalues().array() < unknown).count());
}

void add_edge(const GraphEdge& e, const PoseGraph& graph, const GraphMarginals& marginals,
              const PoseGraphSettings& settings, Component& component) {
  const Eigen::Isometry3d& T_from = graph.poses[static_cast<std::size_t>(e.from)];
  const Eigen::Isometry3d& T_to = graph.poses[static_cast<std::size_t>(e.to)];
  const Matrix6d J = -adjoint(T_to.inverse() * T_from);
  const Matrix6d W = edge_error(e, settings, {}).inverse();
  const Matrix6d across = J * marginals.block(e.from, e.to);
  const Matrix6d adjusted = J * marginals.block(e.from, e.from) * J.transpose() + across +
                            across.transpose() + marginals.block(e.to, e.to);
  const Vector6d v = se3_log(e.T_from_to.T.inverse() * T_from.inverse() * T_to);
  component.squares += v.dot(W * v);
  // What nothing else measures checks nothing, nor takes it away from what others check.
  component.redundancy += std::max(0.0, measured_directions(e) - (W * adjusted).trace());
}

// Whoever has left the plane says nothing of how flat it is.
void add_ground(std::size_t node, const PoseGraph& graph, const GraphMarginals& marginals,
                const PoseGraphSettings& settings, Component& component) {
  const GroundConstraint& ground = *graph.ground;
  if (ground.floor(node) != Floor::plane) return;
  const FloorJacobian A = floor_jacobian(ground);
  const Eigen::Matrix3d adjusted =
      A * marginals.block(static_cast<int>(node), static_cast<int>(node)) * A.transpose();
  const Eigen::Vector3d v = off_ground(graph.poses[node] * ground.T_camera_robot);
  const Eigen::Vector3d variances = ground_error(ground, node, settings, {}).cwiseAbs2();
  component.squares += v.cwiseAbs2().cwiseQuotient(variances).sum();
  component.redundancy += 3 - adjusted.diagonal().cwiseQuotient(variances).sum();
}

}  // namespace

ErrorFactors error_factors(const PoseGraph& graph, const PoseGraphSettings& settings) {
  ErrorFactors factors;
  const auto marginals = GraphMarginals::of(graph, settings, factors);
  if (!marginals) return factors;
  Component edges, floor;
  for (const GraphEdge& e : graph.edges)
    if (!is_odometrys(e)) add_edge(e, graph, *marginals, settings, edges);
  factors.edges = edges.factor(6 * settings.stated_measurements);
  if (!graph.ground) return factors;
  for (std::size_t i = 1; i < graph.poses.size(); ++i) add_ground(i, graph, *marginals, settings, floor);
  factors.ground = floor.factor(3 * settings.stated_measurements);
  return factors;
}

Matrix6d edge_error(const GraphEdge& edge, const PoseGraphSettings& settings, const ErrorFactors& factors) {
  const double sigmas = (is_odometrys(edge) ? 1 : factors.edges) * settings.edge_error;
  return sigmas * sigmas * edge.T_from_to.covariance;
}

Matrix6d frame_error(const Matrix6d& covariance, const PoseGraphSettings& settings) {
  return settings.frame_error * settings.frame_error * covariance;
}

FloorJacobian floor_jacobian(const GroundConstraint& ground) {
  return adjoint(ground.T_camera_robot.inverse()).middleRows<3>(2);
}

Eigen::Vector3d ground_error(const GroundConstraint& ground, std::size_t node,
                             const PoseGraphSettings& settings, const ErrorFactors& factors) {
  return factors.ground * settings.ground_error * ground.sigmas(node);
}

Matrix6d ground_information(const GroundConstraint& ground, std::size_t node,
                            const PoseGraphSettings& settings, const ErrorFactors& factors) {
  const FloorJacobian A = floor_jacobian(ground);
  const Eigen::Vector3d told = ground_error(ground, node, settings, factors).cwiseAbs2().cwiseInverse();
  return A.transpose() * told.asDiagonal() * A;
}

}  // namespace lcmslam
