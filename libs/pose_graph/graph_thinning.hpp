#pragma once
// Keeps a pose graph bounded: nodes whose surroundings other nodes cover best are marginalised, so that what
// was measured from them is kept as measurements between the others.

#include <vector>

#include <lcmslam/pose_graph/pose_graph.hpp>

namespace lcmslam {

struct ThinningNode {
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  bool keyframe = false;
  bool fixed = false;  ///< must stay
};

struct Covering {
  double distance = 0.3;  ///< m and
  double angle = 0.3;     ///< rad that count as much as each other
};

/// Which nodes go so that at most `keyframes` keyframes and `others` other nodes are left: always the one
/// that is nearest, in place and view direction, to a keyframe that stays; of two keyframes the one that has
/// another neighbour nearer by, else the newer. True where a node goes. Fixed ones stay even beyond the
/// limits.
std::vector<bool> covered_nodes(const std::vector<ThinningNode>& nodes, std::size_t keyframes,
                                std::size_t others, const Covering& covering = {});

/// The successor of each node, which takes what belonged to it: itself, or the nearest keyframe that stays (a
/// node that stays where there is none).
std::vector<int> successors(const std::vector<ThinningNode>& nodes, const std::vector<bool>& gone,
                            const Covering& covering = {});

/// Marginalises a node: each of its edges is continued by the edge to the neighbour on the path whose
/// odometry is surest, with the covariances of both. Of all trees that connect its neighbours this is the one
/// that keeps most of what they know of each other (Kretzschmar and Stachniss 2012: the Chow-Liu tree), if
/// that edge is the surest; that the new edges share its error is neglected. Edges beside it sharpen it. Two
/// edges between the same nodes become one, but for odometry, which is never refused and keeps the path in
/// one piece. Node numbers stay. `waiting`: other edges, which are continued alike.
void marginalise(int node, std::vector<GraphEdge>& edges, std::vector<GraphEdge>& waiting);

/// The edges of odometry, and of registrations and of loops those that are among the `most` surest of their
/// kind at one of their ends: what is measured again and again says less and less that is new, and each edge
/// costs. In their order. `nodes`: how many there are.
std::vector<GraphEdge> surest_edges(const std::vector<GraphEdge>& edges, std::size_t nodes, std::size_t most);

/// One edge for two of the same nodes: the mean by their information (first order about a). It is expected as
/// the more cautious of both is: what a registration has sharpened is no longer as sure as odometry alone.
GraphEdge merged(const GraphEdge& a, const GraphEdge& b);

}  // namespace lcmslam
