#pragma once
// The dense surface of a map: what people look at. Keyframes are fused at their poses, and fused anew where
// the graph has moved them.
//
//   Surface surface(calibration);
//   surface.hand_in(keyframe, frame, T_map_camera);
//   surface.move(keyframe, corrected);  // as often as the graph bends
//   surface.forget(keyframe);           // which the graph has given up
//   surface.refuse(2);                  // a few each cycle, so that nothing waits
//   const Mesh mesh = surface.mesh();
//
// The newest keyframes wait until the surface is looked at, or too many of them do: meanwhile the graph bends
// them most, and each is fused once.
//
// Two levels: fine voxels where the camera was near, coarse ones wherever it looked. Both see the same
// frames.

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/surface/kept_view.hpp>
#include <lcmslam/surface/surface_mesh.hpp>
#include <lcmslam/surface/surface_view.hpp>
#include <lcmslam/surface/voxel_blocks.hpp>

namespace lcmslam {

class Surface {
 public:
  /// Throws std::invalid_argument for a calibration or a setting that is wrong.
  explicit Surface(const RgbdCalibration& calibration, const SurfaceSettings& settings = {});

  /// Frames that are handed in from now on are another camera's. Throws as the constructor.
  void look_through(const RgbdCalibration& calibration);

  /// Takes a frame whose depth has passed DepthFilter; `keyframe` is its name for move(). `T_map_camera` is
  /// that of the colour camera at the colour image's time, `T_colour_depth_time` as for DepthRegistration.
  /// Throws std::invalid_argument for images of another size, poses that are not finite, and a keyframe that
  /// is there already.
  /// Where images are too many those go first that came first; before them those `of_before`, of an earlier
  /// map, say, which do not tell where the camera is now, either.
  void hand_in(std::int64_t keyframe, const RgbdFrame& frame, const Eigen::Isometry3d& T_map_camera,
               const Eigen::Isometry3d& T_colour_depth_time = Eigen::Isometry3d::Identity(),
               bool of_before = false);
  /// The same, and nothing waits any more.
  void fuse(std::int64_t keyframe, const RgbdFrame& frame, const Eigen::Isometry3d& T_map_camera,
            const Eigen::Isometry3d& T_colour_depth_time = Eigen::Isometry3d::Identity());

  /// Where a keyframe stands now. One whose images are not kept any more stays where it was fused; its name
  /// is free again.
  void move(std::int64_t keyframe, const Eigen::Isometry3d& T_map_camera);

  /// A keyframe goes, and refuse() takes out what it has put in; its name is free at once. One whose images
  /// are not kept any more leaves the surface as it is. Does nothing where there is none.
  void forget(std::int64_t keyframe);

  /// Fuses all that wait, and takes out at most so many of the keyframes that went, or that moved and are
  /// fused elsewhere then: those that went, then those that moved farthest. Returns how many are left.
  int refuse(int keyframes);

  /// As the surface is now, with all that waited; only what changed is meshed anew.
  Mesh mesh();
  /// The same in its cubes, for who follows it; until something else is called.
  const SurfaceMesh& meshed();

  /// What these keyframes saw, pixel by pixel, at their poses as they are known now; the mean of each voxel
  /// of `resolution` (m). As sharp as the images are that are kept; the mesh is as sharp as its voxels.
  ColouredCloud cloud(const std::vector<std::int64_t>& keyframes, double resolution) const;

  std::size_t memory_bytes() const;
  /// Blocks that went because all were too many (`memory`): the surface lacks what was in them.
  std::size_t given_way() const { return given_way_; }
  const VoxelBlocks& fine() const { return fine_; }
  const VoxelBlocks& coarse() const { return coarse_; }

 private:
  using Arrival = std::pair<bool, std::int64_t>;  // whether it is of now, and number
  struct Keyframe {
    Arrival arrival;
    std::shared_ptr<const SurfaceViewMaker> maker;  // of its camera
    std::optional<SurfaceImage> waiting;            // until it is fused
    std::optional<KeptView> view;                   // then
    Eigen::Isometry3d T_map_camera;                 // as it is fused
    Eigen::Isometry3d T_wanted;
    std::int64_t fused = 0;  // number of the fusion
  };

  void fuse_oldest();
  void fuse_all();
  void put_in(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth);
  void take_out(const SurfaceView& view, const Eigen::Isometry3d& T_map_depth, std::int64_t fused);
  void take_out_gone();
  void keep_bounds();
  /// How far it moved in the units of its thresholds; below 1 it stays.
  double shift(const Keyframe& keyframe) const;

  SurfaceSettings settings_;
  std::shared_ptr<const SurfaceViewMaker> maker_;  // of the newest
  VoxelBlocks fine_, coarse_;
  SurfaceMesh mesh_;
  std::map<std::int64_t, Keyframe> keyframes_;
  std::map<Arrival, std::int64_t> arrivals_;  // keyframes, the first to make room first
  std::int64_t arrived_ = 0;
  std::vector<Keyframe> gone_;        // that are to be taken out
  std::deque<std::int64_t> waiting_;  // of those that are not fused yet, the oldest first
  std::size_t waiting_bytes_ = 0;
  Eigen::Vector3d camera_ = Eigen::Vector3d::Zero();  // newest place, m
  std::int64_t fusion_ = 0;
  std::size_t kept_bytes_ = 0;
  std::size_t given_way_ = 0;
};

}  // namespace lcmslam
