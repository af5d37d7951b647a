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

#include <lcmslam/geometry/ground_plane.hpp>
#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/pose_graph/uncertain_transform.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

enum class EdgeKind : std::uint8_t { odometry, registration, loop };

struct GraphEdge {
  int from = 0, to = 0;  ///< nodes
  EdgeKind kind = EdgeKind::odometry;
  UncertainTransform T_from_to;  ///< with the covariance by which it is weighed
  double error = 0;              ///< Mahalanobis distance after optimisation
  double expected_share = 1;     ///< of its sigmas where it tells what to expect: by odometry alone without
                                 ///< the caution by which measurements are weighed
};

struct PoseGraphSettings {
  double kernel_width = 3;
  double max_error = 5.3;
  int max_iterations = 30;
  double path_gate = 4.74;
  int loop_support = 3;
  double edge_error = 0.1;
  double frame_error = 0.4;
  double ground_error = 0.42;
  double motion_scale = 0.0009;
  double turn_scale = 0.00075;
  double curvature = 0.000165;
  double stretch = 8;
  double stated_measurements = 5;

  void describe(SettingsVisitor& s) {
    s.number("kernel_width", kernel_width, "standard deviations", {0.1, 1e6},
             "of the Cauchy kernel on all edges but odometry's");
    s.number("max_error", max_error, "", {0.1, 1e6},
             "Mahalanobis distance beyond which edges but odometry's are refused (6 DoF, 99.99 %)");
    s.number("max_iterations", max_iterations, "", {1, 10000}, "iterations of each solution");
    s.number("path_gate", path_gate, "", {0, 1e6},
             "a loop this near (Mahalanobis; 6 DoF, 99.9 %) to what the graph expects is believed");
    s.number("loop_support", loop_support, "", {1, 100},
             "other loops are believed when so many from different places agree with each other");
    s.number("edge_error", edge_error, "", {0.001, 1000},
             "what an edge errs by on its own, over the sigma that weighs it (cautiously: one wrong edge "
             "bends the map); "
             "for the poses' covariances");
    s.number(
        "frame_error", frame_error, "", {0.001, 1000},
        "likewise, what a frame errs by beside the newest node, whatever edges contradict each other by: its "
        "points' noise is told less cautiously than an edge's; for the poses' covariances");
    s.number(
        "ground_error", ground_error, "", {0.001, 1000},
        "what the ground is off its plane by, over the sigma that weighs it (cautiously, likewise); for the "
        "poses' covariances");
    s.number(
        "motion_scale", motion_scale, "", {0, 1},
        "standard deviation of a ratio by which all edges of a stretch measure too long or too short ways, "
        "as depth cameras with a systematic error do; for the poses' covariances");
    s.number("turn_scale", turn_scale, "", {0, 1},
             "standard deviation of a ratio by which all edges measure too large or too small turns; for the "
             "poses' "
             "covariances");
    s.number("curvature", curvature, "rad/m", {0, 1},
             "standard deviation of a turn about the vertical by which all edges of a stretch bend straight "
             "ways alike; for the poses' covariances");
    s.number(
        "stretch", stretch, "m", {0.1, 1e6},
        "of the way, for which motion_scale and curvature last; at most 32 of them, longer on longer ways");
    s.number("stated_measurements", stated_measurements, "", {0.1, 1e6},
             "edges, and poses on the ground, as many as the two errors above count for beside what the "
             "graph's measurements contradict each other by: what edges and ground err by follows from both");
  }
};

/// A robot on wheels: each pose times T_camera_robot stands on its node's floor (nodes beyond the end of
/// `floors`: on the plane z = 0).
struct GroundConstraint {
  Eigen::Isometry3d T_camera_robot = Eigen::Isometry3d::Identity();
  GroundSettings plane;
  std::vector<Floor> floors;
  Vector6d mount_sigmas = Vector6d::Zero();  ///< of the mount's error (mount_error.hpp): m, rad, camera frame

  Floor floor(std::size_t node) const { return node < floors.size() ? floors[node] : Floor::plane; }
  /// Standard deviations of height, roll and pitch there.
  Eigen::Vector3d sigmas(std::size_t node) const { return GroundContact(plane, floor(node)).sigmas(); }
};

struct PoseGraph {
  std::vector<Eigen::Isometry3d> poses;  ///< T_world_camera by node; the first one stays
  std::vector<GraphEdge> edges;
  std::optional<GroundConstraint> ground;  ///< nothing for cameras in the hand
};

/// e of an edge at the poses, over its sigmas.
double error_over_sigma(const GraphEdge& edge, const PoseGraph& graph);

/// Moves the poses; refused edges are gone afterwards. The number refused.
int optimise(PoseGraph& graph, const PoseGraphSettings& settings);

}  // namespace lcmslam
