#pragma once
// 6-D SLAM: registers each coloured cloud to a growing map and keeps keyframes.
//
// World is the robot's pose at the first frame (identity). The pose is always finite: while nothing
// can be registered it follows the prediction and the status says so, and the map is left alone.
//
//   DenseMapper mapper;
//   const DenseMapper::Step step = mapper.step(frame);   // frame: see RgbdFrameMaker
//
// step() is the whole algorithm; its parts: MotionModel predicts, a Tracker registers, DeformableMap and
// KeyframeStore keep what was seen, ChangedSpace takes away what is gone, KeyframeGraph corrects all of them.

#include <memory>
#include <optional>
#include <vector>

#include <lcmslam/dense_mapper/carried_watch.hpp>
#include <lcmslam/dense_mapper/changed_space.hpp>
#include <lcmslam/dense_mapper/deformable_map.hpp>
#include <lcmslam/dense_mapper/keyframe_store.hpp>
#include <lcmslam/dense_mapper/tracker.hpp>
#include <lcmslam/dense_mapper/wheel_hold.hpp>
#include <lcmslam/geometry/local_frame.hpp>

namespace lcmslam {

class DenseMapper {
 public:
  using Keyframe = KeyframeStore::Keyframe;

  explicit DenseMapper(const DenseMapperSettings& settings = {});

  struct Step {
    Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
    /// In the map's frame, which is the first pose: of the keyframes that the pose stands on, and against
    /// them.
    Matrix6d map_covariance = Matrix6d::Zero();
    /// Against the map in sight: as cautious as the graph's weights, and as registration has been found to
    /// err. All three: right perturbation, robot frame.
    Matrix6d covariance = Matrix6d::Zero(), local_covariance = Matrix6d::Zero();
    /// The pose in two parts, T_world_local * T_local_robot, of which the second never jumps (LocalFrame).
    Eigen::Isometry3d T_world_local = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_local_robot = Eigen::Isometry3d::Identity();
    RegistrationResult registration;  ///< of the cloud in the robot frame to the world
    MappingStatus status = MappingStatus::initialising;
    bool anchored = false;  ///< features of a keyframe were found again, are believed, and place the robot at
    Eigen::Isometry3d T_world_anchor = Eigen::Isometry3d::Identity();
    double quality = 0;        ///< 0..1: overlap times share of inliers
    bool keyframe = false;     ///< keyframes().back() is new
    bool node = false;         ///< graph().nodes().back() is new
    bool relocalised = false;  ///< lost before, and found far from the prediction
    bool adrift = false;       ///< after a gap without odometry, or carried elsewhere: not found again yet
    bool carried = false;      ///< it is adrift because what it sees contradicts its wheels
    double unplaced =
        0;  ///< s of usable frames since the robot was carried that had no place in the map; 0: this one has
    bool reseeded = false;  ///< odometry alone says where it is: the map goes on from there
    bool held = false;      ///< what is new contradicts the wheels, which are believed: Tracked::held
    bool blocked = false;   ///< what stands close hides the map: the wheels alone say where it is
    bool blind = false;     ///< the depth image gives too few points to say anything
    bool hangs_on_odometry = false;  ///< the map around was begun where odometry led, and is tied to the rest
                                     ///< by nothing else yet
    Floor floor = Floor::plane;      ///< on wheels: what measurements leave of the ground's plane
    bool thinned = false;            ///< redundant nodes have gone from graph() and keyframes()
    bool deformed = false;  ///< the graph moved its nodes before this step: older poses are of the old map
  };

  /// Frames come in order of time.
  Step step(const DenseFrame& frame);

  /// Features that came after the step of their moment: for keyframes.
  void add_features(const FeatureFrame& features, Utime utime);

  /// Keyframes (their indices) whose clouds have changed since they were last published, because what moved
  /// away went or a keyframe that is no more left its points: those that changed notably, or all.
  std::vector<std::size_t> take_changed(bool all = false) { return keyframes_.take_changed(all); }

  /// All work that is left; whether nodes moved.
  bool finish();

  const std::vector<Keyframe>& keyframes() const { return keyframes_.all(); }
  const KeyframeGraph& graph() const { return graph_; }
  /// Of a node of graph(): of T_world_camera exp(xi), m, rad, camera frame; as map_covariance of the robot's
  /// pose there, carried to the camera.
  Matrix6d node_covariance(const KeyframeGraph::Node& node, const Eigen::Isometry3d& T_robot_camera) const;
  const VoxelMap& map() const { return map_.voxels(); }
  /// How many keyframes there have been.
  std::int64_t keyframes_made() const { return keyframes_.made(); }
  /// Of all that is kept from frame to frame.
  std::size_t memory_bytes() const;

 private:
  PreparedFrame prepare(const DenseFrame& frame) const;
  Expectation expect(const DenseFrame& frame) const;
  Expectation expect(const DenseFrame& frame, bool pushed) const;
  void stand_on_ground(const Tracked& tracked, Step& step);
  void start_map(const PreparedFrame& prepared, Step& step);
  void accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot, bool registered);
  bool judge(const Tracked& tracked, const Expectation& expected, const PreparedFrame& prepared, Step& step);
  bool is_found(const Tracked& tracked, Utime utime);
  bool hangs_on_odometry();
  int first_node_here() const;
  Matrix6d covariance_at(const PoseError& error, const Eigen::Isometry3d& T_world_camera,
                         const Eigen::Isometry3d& T_robot_camera) const;
  void tell_covariance(const Eigen::Isometry3d& T_robot_camera, Step& step) const;
  void tell_local_pose(const Expectation& expected, Step& step);
  void grow(const PreparedFrame& prepared, Step& step);
  std::vector<int> shown_keyframes(const Cloud& cloud) const;
  void add_node(const PreparedFrame& prepared, bool keyframe, Step& step);
  bool work_on_graph(Utime utime);
  bool thin();
  void deform(const KeyframeGraph::Correction& correction);

  DenseMapperSettings settings_;
  MotionModel motion_;
  GroundContact ground_;
  LocalFrame local_;
  KeyframeStore keyframes_;
  DeformableMap map_;
  std::unique_ptr<Tracker> tracker_;  // sees map and keyframes
  ChangedSpace changed_space_;
  CarriedWatch carried_;
  WheelHold wheel_hold_;
  KeyframeGraph graph_;
  int bad_steps_ = 0;              // in a row
  int misfits_ = 0;                // of them those that showed something
  std::vector<int> hanging_from_;  // ids of the first nodes of such parts
  int placed_in_a_row_ = 0;        // frames, while adrift
  Utime placed_since_ = 0;         // the first of them
  bool strayed_ = false;           // while adrift: a frame has fitted far from where odometry had led
  Eigen::Isometry3d T_world_inserted_ = Eigen::Isometry3d::Identity();  // robot, at the last insertion
};

}  // namespace lcmslam
