#pragma once
// The keyframes' pose graph, kept beside the frames: a new keyframe is compared with the one before it, with
// those near it, with those whose surfaces it shows again and with loop candidates. A measurement that
// geometry and the graph's own expectation confirm becomes an edge, and the poses are optimised anew.
//
// The work runs in a thread of its own on what was known when it began, and its result is taken over at a
// fixed message time later: the same log gives the same result however fast the machine is. A machine
// that is slower than that time waits.

#include <future>
#include <memory>
#include <optional>
#include <vector>

#include <lcmslam/pose_graph/graph_thinning.hpp>
#include <lcmslam/pose_graph/loop_finder.hpp>
#include <lcmslam/pose_graph/pose_covariance.hpp>
#include <lcmslam/pose_graph/pose_graph.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct KeyframeGraphSettings {
  bool enabled = true;
  PoseGraphSettings optimiser;
  LoopFinderSettings loops;
  int neighbours = 2;
  int shown = 2;
  double vague = 6;
  double max_distance = 1.0;
  double max_angle = 0.7;
  double floor_translation = 0.01;
  double floor_rotation = 0.005;
  double min_translation = 0.004;
  double min_rotation = 0.003;
  double wait = 0.2;
  double time = 0.3;
  double time_per_node = 0.002;
  /// Keyframes that are kept, and as many other nodes, of which there are fifty or one for each keyframe; a
  /// tenth of them goes at a time (about 0.25 MB each).
  /// Its key is the mapper's.
  int max_keyframes = 600;
  int max_waiting = 200;

  void describe(SettingsVisitor& s) {
    s.flag("enabled", enabled, "keyframes are compared with each other and their poses optimised");
    s.section("optimiser", optimiser, "the poses that explain the measurements best");
    s.section("loops", loops, "whether the camera has been here before");
    s.number("neighbours", neighbours, "", {0, 100},
             "nearest keyframes that a new node is compared with, besides the one before it");
    s.number("shown", shown, "", {0, 100},
             "earlier keyframes whose surfaces a new node shows again, from whichever side, that it is "
             "compared with");
    s.number("vague", vague, "", {0, 1e6},
             "times an edge's noise floor (loops.floor_*): where the graph errs by less in every direction "
             "between a node and a keyframe whose surfaces it shows again, they are not compared");
    s.number("max_distance", max_distance, "m", {0, 1000}, "between the cameras of neighbours");
    s.number("max_angle", max_angle, "rad", {0, 3.1416}, "between the cameras of neighbours");
    s.number("floor_translation", floor_translation, "m", {0, 1000},
             "noise floor of the motion between two keyframes, added (squared): the map pulls it along");
    s.number("floor_rotation", floor_rotation, "rad", {0, 3.1416},
             "noise floor of the motion between two keyframes, added (squared)");
    s.number("min_translation", min_translation, "m", {0, 1000},
             "smaller corrections are not worth deforming the map for");
    s.number("min_rotation", min_rotation, "rad", {0, 3.1416},
             "smaller corrections are not worth deforming the map for");
    s.number("wait", wait, "s", {0, 10}, "of message time that the work waits for a keyframe's features");
    s.number("time", time, "s", {0, 100},
             "of message time that the graph's work may take, besides time_per_node");
    s.number("time_per_node", time_per_node, "s", {0, 1},
             "of message time that the graph's work may take for each node, besides time");
    s.number("max_waiting", max_waiting, "", {0, 1e6}, "edges that are not believed yet, the newest ones");
  }
};

class KeyframeGraph {
 public:
  explicit KeyframeGraph(const KeyframeGraphSettings& settings);

  struct Node {
    Utime utime = 0;
    Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
    int id = 0;  ///< of all that ever were; nodes are called by their index, which changes when others go
    bool keyframe = false;
    Floor floor = Floor::plane;  ///< a robot on wheels: what it stood on
    /// Of T_world_camera, as seen from the first node; grows with the edges behind the last work. For the
    /// robot's pose, which stands on the newest one.
    PoseError error;
    /// The same with edges that err alike (EdgeErrors): of nodes with many edges, as a map at rest has them.
    PoseError map_error;
  };

  /// Where each node goes: T_world_new = by_node[id] * T_world_old. Things of newer nodes go with the last.
  using Correction = std::vector<Eigen::Isometry3d>;

  /// For robots on the ground; nothing for cameras in the hand.
  void set_ground(const std::optional<GroundConstraint>& ground) { ground_ = ground; }

  /// Whose covariance a new node has: registration's is told cautiously, odometry's says what it errs by. Who
  /// was lost and is found again stands where it shows what others have seen, however it came there: the path
  /// goes on from the keyframe that it shows most of, not from the last node.
  enum class PlacedBy { registration, odometry, relocalisation };

  /// A new node, numbered from 0. `covariance` of tracking there, against the map (camera's body frame).
  /// `keyframe`: later ones are compared with it. `floor`: that a robot on wheels stood on.
  int add(Utime utime, const Eigen::Isometry3d& T_world_camera, const Matrix6d& covariance, KeyframeView view,
          bool keyframe, Floor floor = Floor::plane, PlacedBy by = PlacedBy::registration);
  /// What was seen from the newest node, when it comes later than its cloud. False when it is too late.
  bool add_features(int node, const FeatureFrame& features);

  /// Once a frame: begins work that is due, and gives the correction when work that is done moves poses
  /// notably. They move with apply().
  std::optional<Correction> work(Utime now);
  /// All that is left to do, on the poses as they stand: work under way whose result was not taken over, and
  /// corrections too small until now, count too.
  std::optional<Correction> finish();
  void apply(const Correction& correction);

  /// Nodes that went, and the new index of each old one; of those that went, of their
  /// successor.
  struct Thinned {
    std::vector<bool> gone;
    std::vector<int> index;
  };
  /// Marginalises redundant nodes when there are too many and no work is under way (which waits for work()).
  std::optional<Thinned> thin(const Covering& covering);
  bool at_work() const { return running_.valid(); }

  /// Of all that is kept; what work under way touches, as it was when that began.
  std::size_t memory_bytes() const;

  /// Parts of the graph begin at these ids, ascending: whether more than odometry connects the last of them,
  /// perhaps over others, with what is before the first.
  bool ties(const std::vector<int>& first_ids) const;

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<GraphEdge>& edges() const { return edges_; }
  /// What edges err by on their own, by the last work.
  const ErrorFactors& error_factors() const { return factors_; }

 private:
  struct NewNode {
    std::shared_ptr<KeyframeView> view;
    bool keyframe = false;
    Utime utime = 0;
  };
  struct Solution {
    PoseGraph graph;
    std::vector<GraphEdge> waiting;
    std::vector<PoseError> errors, map_errors;
    ErrorFactors factors;
  };
  /// When the poses are optimised: when a circle closes anew, or wherever there is one.
  enum class Optimise { new_circles, any_circle };

  void begin(Utime now, Optimise when);
  void take(Solution solution);
  void adopt_errors();
  void carry_error(std::size_t node);
  std::optional<Correction> notable_correction(double min_translation, double min_rotation) const;
  static Solution solve(PoseGraph graph, std::vector<GraphEdge> waiting, const std::vector<NewNode>& fresh,
                        LoopFinder& finder, const KeyframeGraphSettings& settings, Optimise when);

  KeyframeGraphSettings settings_;
  std::vector<Node> nodes_;
  int next_id_ = 0;
  std::vector<GraphEdge> edges_, waiting_;  // waiting: measured, not believed yet
  std::optional<GroundConstraint> ground_;  // of which nodes tell who has left it
  std::vector<NewNode> fresh_;
  LoopFinder finder_;  // only the work touches it
  std::size_t edges_begun_ = 0, finder_bytes_ = 0;
  std::vector<Eigen::Isometry3d> solved_;                     // poses that the last work found
  std::vector<PoseError> solved_errors_, solved_map_errors_;  // theirs, until the poses are there
  ErrorFactors factors_, solved_factors_;  // by which the nodes' errors were made, and those
  Utime due_ = 0;
  std::future<Solution> running_;  // the last member: it waits for the work before the rest goes
};

}  // namespace lcmslam
