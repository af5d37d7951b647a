#pragma once
// Poses of keyframes, what was measured between them, and the poses that explain the measurements best.
//
//   e_ij = log(Z_ij^-1 T_i^-1 T_j),  minimise  sum rho(e_ij' S_ij^-1 e_ij)
//
// (Lu and Milios 1997; Grisetti et al. 2010). Measurements that may be false carry a robust kernel, and what
// still contradicts the others afterwards is refused. One thread, no randomness: the same graph, the same
// poses.

#include <cstdint>
#include <optional>
#include <vector>

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

enum class EdgeKind : std::uint8_t { odometry, registration, loop };

struct GraphEdge {
  int from = 0, to = 0;  ///< nodes
  EdgeKind kind = EdgeKind::odometry;
  UncertainTransform T_from_to;
  double error = 0;  ///< Mahalanobis distance after optimisation
};

struct PoseGraphSettings {
  double kernel_width = 3;  ///< standard deviations: Cauchy kernel on all but odometry
  double max_error = 5.3;   ///< Mahalanobis distance; edges (not odometry) beyond are refused: 6 DoF, 99.99 %
  int max_iterations = 30;  ///< of each solution
  double path_gate = 4.74;  ///< a loop this near (6 DoF, 99.9 %) to what the graph expects is believed, and
  int loop_support = 3;     ///< others when so many from different places agree with each other
  double plane_height = 0.01, plane_tilt = 0.004;  ///< m and rad: how well the floor is a plane
};

struct PoseGraph {
  std::vector<Eigen::Isometry3d> poses;  ///< T_world_camera by node; the first one stays
  std::vector<GraphEdge> edges;
  /// For robots on the ground: each pose times this, T_camera_robot, lies on z = 0 without tilt.
  std::optional<Eigen::Isometry3d> T_camera_on_ground;
};

/// e of an edge at the poses, over its sigmas.
double error_over_sigma(const GraphEdge& edge, const PoseGraph& graph);

/// T_from_to as the graph has it, its covariance that of the surest chain of edges between them; nothing
/// when they are not connected.
std::optional<UncertainTransform> expected(const PoseGraph& graph, int from, int to);

/// Whether both, with the graph's chains between their ends, close a circle (Mangelson et al. 2018).
bool consistent(const GraphEdge& a, const GraphEdge& b, const PoseGraph& graph,
                const PoseGraphSettings& settings);

/// Takes from `waiting` what can be believed and adds it to the graph: what agrees with the graph's own
/// expectation, and groups that agree with each other. The number added.
int admit(std::vector<GraphEdge>& waiting, PoseGraph& graph, const PoseGraphSettings& settings);

/// Moves the poses; refused edges are gone afterwards. The number refused.
int optimise(PoseGraph& graph, const PoseGraphSettings& settings);

}  // namespace lcmslam
