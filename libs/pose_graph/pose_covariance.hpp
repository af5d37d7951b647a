#pragma once
// How wrong the poses of a graph may be, as seen from the first one: their marginal covariances.
//
//   H = sum J_ij^T R_ij^-1 J_ij + ground,   covariance of pose i: block (i, i) of H^-1 + G G^T
//   G = H^-1 sum J_ij^T R_ij^-1 b_ij
//
// R is what an edge errs by, which is less than what it is weighed by: weights are cautious, because one edge
// that is wrong bends the map (PoseGraphSettings::edge_error, ground_error). Only the
// entries of H^-1 that its sparse factor has are computed (Takahashi, Fagan and Chin 1973; Erisman and Tinney
// 1975), so the cost is that of the factorisation. b are the errors that all edges share
// (PoseGraphSettings::motion_scale, turn_scale): they do not average out along the way, and only a map that
// closes resists them.

#include <vector>

#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// Of poses[i] exp(xi): m, rad, body frame, by node; the first one's is zero. Nothing when the edges do not
/// tie all nodes to the first.
std::vector<Matrix6d> pose_covariances(const PoseGraph& graph, const PoseGraphSettings& settings);

/// What an edge, or tracking that may become one, errs by: from the covariance by which it is weighed.
Matrix6d edge_error(const Matrix6d& covariance, const PoseGraphSettings& settings);

}  // namespace lcmslam
