#pragma once
// All layers that are derived from a map, following it as it grows: free and occupied space, distances,
// planes, the dense surface. One thread shows frames; any thread asks.
//
//   LiveMap map(calibration);
//   map.show(frame, pose);            // at the rate that the machine bears
//   map.keep(keyframe, frame, pose);  // each keyframe
//   map.follow(poses);                // as often as the graph bends, or thins itself out
//   while (map.improve()) ...         // when nothing else is to be done
//   map.space().ask(...);

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/live_map/live_planes.hpp>
#include <lcmslam/live_map/live_space.hpp>
#include <lcmslam/surface/surface.hpp>

namespace lcmslam {

/// Where the head was when a frame's images were taken.
struct FramePose {
  Eigen::Isometry3d T_map_camera =
      Eigen::Isometry3d::Identity();  ///< colour camera at the colour image's time
  /// As DepthRegistration takes it; identity where both are of one moment.
  Eigen::Isometry3d T_colour_depth_time = Eigen::Isometry3d::Identity();
};

class LiveMap {
 public:
  using Calibration = std::shared_ptr<const RgbdCalibration>;

  /// Throws std::invalid_argument for a calibration or a setting that is wrong.
  explicit LiveMap(const RgbdCalibration& calibration, const LiveMapSettings& settings = {});
  explicit LiveMap(Calibration calibration, const LiveMapSettings& settings = {});

  // One thread. Images of another size than the calibration's are std::invalid_argument.

  /// Frames and keyframes that follow are of this camera; all others stay as they are. The same object is the
  /// same camera: what was learned of it is still known. Throws std::invalid_argument for one that is wrong.
  void look_through(const Calibration& calibration);
  /// What the frame sees through becomes free, what it sees is occupied. Colour is not asked for.
  void show(RgbdFrame frame, const FramePose& pose);
  /// It shows what stands in the way now, and nothing is learned of it: its place is not sure enough.
  void glance(RgbdFrame frame, const FramePose& pose);
  /// As show(), and the surface grows by it; it moves with the keyframe that was kept last.
  void add(RgbdFrame frame, const FramePose& pose);
  /// What was seen before is no news of what stands in the way now, or of where the camera is.
  enum class When { now, before };
  /// The same, and it is kept: the surface and planes grow by it. A keyframe that is there already is left as
  /// it is.
  void keep(int keyframe, RgbdFrame frame, const FramePose& pose, When when = When::now);
  /// A keyframe of which only the cloud (camera frame, m) is there: space and planes grow by it, the surface
  /// does not.
  void keep(int keyframe, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_camera,
            When when = When::now);
  /// The same for a keyframe of another map, seen before: frames that follow do not hang on it, and it makes
  /// room for the map's own. Left out where there is none.
  void adopt(int keyframe, RgbdFrame frame, const FramePose& pose);
  void adopt(int keyframe, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_camera);
  /// Where keyframes stand, T_map_camera by keyframe.
  void correct(std::map<int, Eigen::Isometry3d> T_map_camera);
  /// The same by a whole graph: keyframes that it does not name have been given up. What they saw is still
  /// there, and each moves with the nearest keyframe that stays; when there are too many for
  /// occupancy.max_keyframes the oldest of them make room, then adopted ones. Those stay where they are; and
  /// a graph that lacks the most of the others is none of this map's, nothing is given up by it.
  void follow(const std::map<int, Eigen::Isometry3d>& T_map_camera);
  /// A piece of the surface's work that was left; false: there is none.
  bool improve();
  /// Where no frame comes for now: space and planes make anew what waits for one. False: nothing is left.
  bool catch_up();
  /// How soon improve() is worth its time: while nobody looks at the surface it need not follow the graph.
  enum class Haste { none, some, much };
  Haste haste() const;
  /// All that is left.
  void settle();

  // Any thread.

  const LiveMapSettings& settings() const { return settings_; }
  const LiveSpace& space() const { return space_; }
  std::vector<PlanePatch> planes() const { return planes_.patches(); }
  /// Takes its time (a second for a flat); only what changed since it was last asked for is meshed anew.
  Mesh mesh() const;
  /// With all that was left of the surface's work, for who asks once: it is not watched by that.
  Mesh settled_mesh() const;
  /// What the keyframes saw: the mean of each voxel of `resolution` (m). Takes its time, too.
  ColouredCloud cloud(double resolution) const;
  /// The cubes of the mesh that changed after `changed` (SurfaceMesh), each with what is in it now. Returns
  /// the newest change.
  using SeeCube = std::function<void(const MeshCube&, const Mesh&)>;
  std::int64_t changed_mesh(std::int64_t changed, const SeeCube& see) const;
  bool has(int keyframe) const;
  /// Counts every change.
  std::int64_t version() const;
  std::size_t memory_bytes() const;
  /// Whether a part of the surface went because all of it was too much (`surface.memory`).
  bool surface_gave_way() const;

 private:
  struct Camera {
    Camera(Calibration calibration, const LiveMapSettings& settings);
    Calibration calibration;
    DepthFilter filter;
    RangeError range_error;
  };
  const RgbdCalibration& calibration() const { return *cameras_.front().calibration; }
  void clean(RgbdFrame& frame);
  void show_depth(const cv::Mat& depth, const Eigen::Isometry3d& T_map_depth, When when);
  void kept(int keyframe, const Eigen::Isometry3d& T_map_camera, const Eigen::Isometry3d& T_camera_depth);
  void fuse(std::int64_t id, const RgbdFrame& frame, const FramePose& pose, When when);
  void hang_up(const std::vector<int>& given_up);
  std::optional<LiveSpace::Place> place_of_nearest(const Eigen::Isometry3d& T_map_camera) const;
  bool make_room();
  void forget(const std::vector<int>& keyframes);
  int nearest(const Eigen::Isometry3d& T_map_camera) const;
  void frame_shown();
  void changed();
  void settle_surface() const;
  bool watch_surface() const;

  LiveMapSettings settings_;
  std::list<Camera> cameras_;  // that of the frames that come first, then those of before
  LiveSpace space_;
  LivePlanes planes_;

  mutable std::mutex surface_mutex_;
  mutable Surface surface_;                       // meshes what changed when it is asked
  mutable std::atomic<int> unwatched_;            // frames since somebody looked at it
  mutable std::atomic<bool> fell_behind_{false};  // while nobody did
  mutable std::atomic<std::size_t> surface_bytes_{0};

  struct Keyframe {
    Eigen::Isometry3d T_map_camera, T_camera_depth;  // depth camera at its own time
    bool is_adopted = false;
  };
  struct Hanging {  // moves with a keyframe of the graph
    int keyframe;
    Eigen::Isometry3d T_keyframe_camera;
  };
  std::map<std::int64_t, Hanging> between_;  // frames of the surface that are no keyframes, by their id there
  std::map<std::int64_t, Hanging> given_up_;  // keyframes that the graph has no more

  mutable std::mutex mutex_;
  std::map<int, Keyframe> keyframes_;
  std::int64_t version_ = 0;
};

/// The depth image that a camera at the cloud's origin would have of it, CV_16UC1 mm, 0 where no point is.
/// Points are as large as the space between a keyframe's points.
cv::Mat depth_of_cloud(const ColouredCloud& cloud, const CameraModel& camera);

}  // namespace lcmslam
