#pragma once
// How wrong the poses of a graph may be, as seen from the first one: their marginal covariances,
//
//   of pose i: block (i, i) of H^-1 + G G^T   (graph_marginals.hpp)
//
// R is what an edge errs by, which is less than what it is weighed by: weights are cautious, because one edge
// that is wrong bends the map (PoseGraphSettings::edge_error, ground_error); by how much it is, the graph
// itself tells (error_factors.hpp). The errors b that all edges share (PoseGraphSettings::motion_scale,
// turn_scale) do not average out along the way, and only a map that closes resists them.

#include <vector>

#include <lcmslam/pose_graph/error_factors.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

/// Of poses[i] exp(xi): m, rad, body frame, by node; the first one's is zero. Nothing when the edges do not
/// tie all nodes to the first.
std::vector<Matrix6d> pose_covariances(const PoseGraph& graph, const PoseGraphSettings& settings,
                                       const ErrorFactors& factors = {});

}  // namespace lcmslam
