#pragma once
// Where a frame is taken from: the part of the mapper that registers. The mapper predicts, grows the map and
// keeps the graph; how a frame is placed in the map is a tracker's business alone.

#include <memory>
#include <optional>
#include <string>

#include <lcmslam/dense_mapper/dense_mapper_settings.hpp>
#include <lcmslam/rgbd/dense_frame.hpp>

namespace lcmslam {

class DeformableMap;
class KeyframeStore;

enum class MappingStatus { initialising, tracking, degraded, lost };
std::string to_string(MappingStatus status);

/// A frame and its trustworthy points, one in each voxel, in the robot's frame.
struct PreparedFrame {
  const DenseFrame& frame;
  Cloud cloud;
  bool accompanied = false;  ///< something new goes with the robot: what is new tells nothing of its way
};

/// What the mapper knows before a frame is registered.
struct Expectation {
  Prior prior;  ///< of T_world_robot, by the motion and, on wheels, by the floor
  Floor floor = Floor::free;
  std::optional<Prior> off_ground;  ///< by the motion alone, where the floor is part of `prior`
  Prior step;  ///< as `prior`, but of this step alone, whatever is not known of T_world_last
  Eigen::Isometry3d T_world_last = Eigen::Isometry3d::Identity();  ///< of the frame before
  int bad_steps = 0;    ///< frames in a row that were not tracked until now
  bool adrift = false;  ///< nobody knows how the robot moved since it was tracked: it may be anywhere
  /// Where its wheels stand: where it has stood since they stopped, unless it was pushed.
  std::optional<Eigen::Isometry3d> T_world_stood;
  /// And the same as all of this, had somebody pushed it now.
  std::shared_ptr<const Expectation> pushed;
};

struct Tracked {
  RegistrationResult registration;  ///< of the cloud in the robot frame to the world
  MappingStatus status = MappingStatus::lost;
  double quality = 0;   ///< 0..1: overlap times share of inliers
  Prior prior;          ///< what was known before registration, by features too
  bool held = false;    ///< by wheels and settled surfaces: new ones would have led it too far from there
  bool pushed = false;  ///< it fits, and so does what stands still, where only a push can have led
  std::optional<Floor> refused_for;  ///< measurements refused the floor; placed without it, and this is seen
  bool anchored = false;  ///< features of a keyframe were found again, are believed, and place the robot at
  Eigen::Isometry3d T_world_anchor = Eigen::Isometry3d::Identity();
};

class Tracker {
 public:
  virtual ~Tracker() = default;

  virtual Tracked track(const PreparedFrame& prepared, const Expectation& expected) = 0;

  /// The frame, at T_world_robot, becomes part of the map. `registered`: it was placed there by track(), or
  /// begins the map; else odometry alone did.
  virtual void accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot,
                      bool registered) = 0;

  /// Whether the map that is published is a cloud of the tracker's own, which grows by what each accepted
  /// frame adds: coloured, in the world. Else keyframes are published as they were seen.
  virtual bool grows() const { return false; }
  virtual ColouredCloud joined() const { return {}; }

  /// Whether a robot that may be anywhere (Expectation::adrift) is looked for in the whole map.
  virtual bool searches_map() const { return false; }

  /// Features of a keyframe, at a node of the graph.
  virtual void add_keyframe(const FeatureFrame&, const Eigen::Isometry3d& /*T_world_camera*/, int /*node*/) {}

  /// The map has been deformed; things move with their nodes.
  virtual void deform(const KeyframeGraph::Correction&) {}
  /// Nodes have gone from the graph.
  virtual void renumber(const KeyframeGraph::Thinned&) {}

  virtual std::size_t memory_bytes() const { return 0; }
};

/// The one that the settings' `variant` names. Map and keyframes must outlive it.
std::unique_ptr<Tracker> make_tracker(const DenseMapperSettings& settings, DeformableMap& map,
                                      const KeyframeStore& keyframes);

/// Share of a registration's pairs that are inliers; 0 without pairs.
double inlier_share(const RegistrationResult& registration);

}  // namespace lcmslam
