#pragma once
// By how much edges and ground err more, or less, than the settings say, as a graph's measurements contradict
// each other: variance components (Helmert 1907; Foerstner 1979).
//
// Of a group of measurements with residuals v and errors R, the adjusted graph leaves over in the mean
//
//   E v^T R^-1 v = s^2 r,   r = sum (dimension - trace R^-1 J H^-1 J^T)
//
// r is the group's redundancy: what of it other measurements check. What the settings say counts as a few
// measurements that agree with it (a scaled inverse chi square prior), so a graph that checks nothing keeps
// it. Where a camera shows the same thing at another place from afar than from near, as on the plain walls of
// a corridor, edges contradict each other by more than in a room; and a floor on which the poses come out
// level is known to be so. What does not contradict itself, because all edges share it, nothing of this
// tells.

#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// On standard deviations.
struct ErrorFactors {
  double edges = 1, ground = 1;
};

/// Of an optimised graph.
ErrorFactors error_factors(const PoseGraph& graph, const PoseGraphSettings& settings);

/// What an edge errs by: from the covariance by which it is weighed. How registrations contradict each other
/// tells nothing of odometry.
Matrix6d edge_error(const GraphEdge& edge, const PoseGraphSettings& settings, const ErrorFactors& factors);
/// And tracking between two nodes, beside the newest one. It nearly shares that one's view, so how edges
/// between other views contradict each other tells nothing of it.
Matrix6d frame_error(const Matrix6d& covariance, const PoseGraphSettings& settings);

/// Height, roll and pitch of the robot by the camera's pose exp(xi).
using FloorJacobian = Eigen::Matrix<double, 3, 6>;
FloorJacobian floor_jacobian(const GroundConstraint& ground);
/// Standard deviations of height, roll and pitch there, robot's frame: what the ground is off its plane by.
Eigen::Vector3d ground_error(const GroundConstraint& ground, std::size_t node,
                             const PoseGraphSettings& settings, const ErrorFactors& factors);
/// What it tells of the camera's pose exp(xi): information.
Matrix6d ground_information(const GroundConstraint& ground, std::size_t node,
                            const PoseGraphSettings& settings, const ErrorFactors& factors);
}  // namespace lcmslam
