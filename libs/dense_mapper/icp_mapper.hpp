#pragma once
// 6-D SLAM: registers each coloured cloud to a growing map and keeps keyframes.
//
// World is the robot's pose at the first frame (identity). The pose is always finite: while nothing
// can be registered it follows the prediction and the status says so, and the map is left alone.

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/feature_anchor.hpp>
#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/dense_mapper/last_view.hpp>
#include <lcmslam/dense_mapper/map_target.hpp>
#include <lcmslam/dense_mapper/motion_prior.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_variant.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/pose_graph/keyframe_graph.hpp>
#include <lcmslam/registration/registration.hpp>
#include <lcmslam/rgbd/depth_clock.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

inline constexpr Choice<CorrespondenceKind> correspondence_names[] = {
    {"voxel_map", CorrespondenceKind::voxel_map},
    {"kd_tree", CorrespondenceKind::kd_tree},
    {"projective", CorrespondenceKind::projective},
    {"normal_shooting", CorrespondenceKind::normal_shooting}};

struct IcpMapperSettings {
  CloudFilterSettings filter;
  VoxelMapSettings map;
  MotionPriorSettings prior;
  FeatureAnchorSettings features;
  DepthClockSettings depth_clock;
  KeyframeGraphSettings graph;
  FreeSpaceSettings free_space;

  // registration: a coarse pass over few points from far, then a fine one
  double voxel_size = 0.04;
  CorrespondenceKind correspondence = CorrespondenceKind::voxel_map;
  double view_radius = 5;
  RegistrationSettings coarse = coarse_defaults();
  RegistrationSettings fine = fine_defaults();
  ColourOverlapSettings overlap;

  VariantKind variant = VariantKind::modern;
  ThesisSettings thesis;

  // trust
  int min_points = 200;
  double lost_overlap = 0.25;
  double good_overlap = 0.40;
  double good_inliers = 0.5;
  double max_jump = 0.30;
  double max_turn = 0.35;
  int reseed_after = 10;
  int recovery_keyframes = 3;

  // growth
  double insert_distance = 0.02;
  double insert_angle = 0.02;
  double keyframe_distance = 0.3;
  double keyframe_angle = 0.3;
  double keyframe_overlap = 0.5;
  double keyframe_voxel = 0.02;
  double keyframe_points = 6e6;
  int keyframe_features = 600;

  double bend_time = 0.05;
  double bend_time_per_surfel = 5e-7;

  void describe(SettingsVisitor& s);

  static RegistrationSettings coarse_defaults();
  static RegistrationSettings fine_defaults();

  /// Whether the passes' metric compares colours: then clouds must bring intensities.
  bool uses_colour() const { return coarse.colour_scale > 0 || fine.colour_scale > 0; }
  /// Whether a rejector compares images: then each step needs its own.
  bool compares_images() const { return coarse.colour_overlap || fine.colour_overlap; }
};

enum class MappingStatus { initialising, tracking, degraded, lost };
std::string to_string(MappingStatus status);

class IcpMapper {
 public:
  explicit IcpMapper(const IcpMapperSettings& settings = {});
  IcpMapper(const IcpMapper&) = delete;  // the view points to the map
  IcpMapper& operator=(const IcpMapper&) = delete;

  struct Step {
    Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
    Matrix6d covariance = Matrix6d::Zero();  ///< against the map; right perturbation, robot frame
    RegistrationResult registration;         ///< of the cloud in the robot frame to the world
    MappingStatus status = MappingStatus::initialising;
    bool anchored = false;  ///< features of a keyframe were found again, are believed, and place the robot at
    Eigen::Isometry3d T_world_anchor = Eigen::Isometry3d::Identity();
    double quality = 0;        ///< 0..1: overlap times share of inliers
    bool keyframe = false;     ///< keyframes().back() is new
    bool node = false;         ///< graph().nodes().back() is new
    bool relocalised = false;  ///< lost before, and found far from the prediction
    bool thinned = false;      ///< redundant nodes have gone from graph() and keyframes()
    bool bent = false;         ///< the graph moved its nodes before this step: older poses are of the old map
  };

  struct Keyframe {
    int id = 0;  ///< index of its node in graph()
    Utime utime = 0;
    Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
    ColouredCloud cloud;      ///< camera frame, with normals
    double voxel = 0;         ///< m, of that cloud
    std::size_t changed = 0;  ///< points that went or came since the cloud was told
  };

  /// Makes the coloured cloud of a step that becomes a keyframe.
  using Painter = std::function<ColouredCloud()>;

  /// `cloud` stands in the camera frame at `utime` and needs normals. `motion` is the robot's motion
  /// since the previous step where odometry knows it; `features` are of the same moment, null where they are
  /// not there; `colour` is what the thesis's variants ask for. Steps come in order of time.
  Step step(Utime utime, const Cloud& cloud, const Painter& coloured, const Eigen::Isometry3d& T_robot_camera,
            const std::optional<Motion>& motion = std::nullopt, const FeatureFrame* features = nullptr,
            const ColourView* colour = nullptr);
  /// The same where the colours are there already.
  Step step(Utime utime, const ColouredCloud& cloud, const Eigen::Isometry3d& T_robot_camera,
            const std::optional<Motion>& motion = std::nullopt, const FeatureFrame* features = nullptr,
            const ColourView* colour = nullptr);

  /// Features that came after the step of their moment: for keyframes.
  void add_features(const FeatureFrame& features, Utime utime);

  /// Keyframes (their indices) whose clouds have changed since they were last told, because what moved away
  /// went or a keyframe that is no more left its points: those that changed notably, or all.
  std::vector<std::size_t> take_changed(bool all = false);

  /// All work that is left; whether nodes moved.
  bool finish();

  const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  const KeyframeGraph& graph() const { return graph_; }
  const VoxelMap& map() const { return *map_; }
  /// How many keyframes there have been.
  std::int64_t keyframes_made() const { return keyframes_made_; }
  /// Of all that is kept from frame to frame, but for work on the graph under way.
  std::size_t memory_bytes() const;

 private:
  struct Attempt {
    RegistrationResult registration;
    MappingStatus status = MappingStatus::lost;
    double quality = 0;
  };

  void start_map(Utime utime, const Painter& coloured, const Cloud& cloud,
                 const Eigen::Isometry3d& T_robot_camera, const FeatureFrame* features, Step& step);
  Eigen::Isometry3d free_motion(Utime utime) const;
  std::vector<Eigen::Isometry3d> starts(const Prior& prior, const std::optional<Motion>& motion,
                                        const std::optional<Prior>& anchor, const FeatureFrame* features,
                                        const Eigen::Isometry3d& T_robot_camera);
  double score(const Cloud& cloud, const Eigen::Isometry3d& T_world_robot) const;
  Attempt try_starts(const Cloud& cloud, std::vector<Eigen::Isometry3d> starts, const Prior& prior,
                     const Eigen::Isometry3d& T_robot_camera);
  Prior judged(const Cloud& cloud, const Prior& odometry, const Prior& anchor,
               const Eigen::Isometry3d& T_robot_camera);
  Attempt attempt(const Cloud& cloud, const Target& target, const Eigen::Isometry3d& T_start,
                  const Prior& prior) const;
  Attempt thesis_attempt(const ThesisFrame& frame, const Eigen::Isometry3d& T_predicted) const;
  MappingStatus judge(const RegistrationResult& result, const Prior& prior) const;
  void grow(Utime utime, const Painter& coloured, const Cloud& cloud, const Eigen::Isometry3d& T_robot_camera,
            const FeatureFrame* features, Step& step);
  void add_node(Utime utime, const Painter& coloured, const Cloud& cloud,
                const Eigen::Isometry3d& T_robot_camera, const FeatureFrame* features, bool keyframe,
                Step& step);
  bool keyframe_due(const Eigen::Isometry3d& T_world_camera, double overlap) const;
  bool is_far(const Eigen::Isometry3d& T_world_camera, const Eigen::Isometry3d& T_world_other,
              double share) const;
  bool work_on_graph(Utime utime);
  bool thin();
  void merge_next_retired();
  bool finish_graph();
  void insert(Cloud cloud_in_world, const Eigen::Vector3d& view_point, int node);
  void restore(const Eigen::Isometry3d& T_world_camera);
  void bound_keyframes(const Eigen::Isometry3d& T_world_camera);
  void bend(const KeyframeGraph::Correction& correction);
  void look_through(const Cloud& cloud, const Eigen::Isometry3d& T_world_camera);
  void begin_sweep();
  void index_swept();
  void clean_next_keyframe();
  void clean(Keyframe& keyframe);

  IcpMapperSettings settings_;
  std::unique_ptr<VoxelMap> map_;
  MapTarget view_;
  FeatureAnchor anchor_;
  LastView last_view_;
  std::optional<ThesisVariant> thesis_;
  std::vector<Keyframe> keyframes_;
  std::int64_t keyframes_made_ = 0;
  std::deque<Keyframe> retired_;  // thinned out; their clouds join their neighbours', one a frame
  bool started_ = false;
  int bad_steps_ = 0;              // in a row
  std::size_t next_recovery_ = 0;  // keyframe to try next while lost
  Utime last_utime_ = 0;
  Eigen::Isometry3d T_world_last_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_inserted_ = Eigen::Isometry3d::Identity();
  Vector6d velocity_ = Vector6d::Zero();  // per second, robot frame

  KeyframeGraph graph_;
  // While the map is bent (in a thread of its own, see KeyframeGraph), it does not grow.
  struct Insertion {
    Cloud cloud;
    Eigen::Vector3d view_point;
    int node = 0;
  };
  std::vector<Insertion> insertions_;

  // Places that were seen through, on their way into the keyframes' clouds: one keyframe a frame.
  std::int32_t looks_ = 0;
  std::vector<VoxelMap::Gone> gone_, swept_;  // collected; being swept (empty: no sweep)
  VoxelIndex swept_voxels_;                   // the map's voxels that swept_ touches
  Eigen::AlignedBox3f swept_box_;
  std::size_t next_swept_ = 0;  // keyframe

  KeyframeGraph::Correction correction_;
  Utime bent_at_ = 0;
  std::future<std::unique_ptr<VoxelMap>> bending_;
};

}  // namespace lcmslam
