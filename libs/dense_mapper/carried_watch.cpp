#include <lcmslam/dense_mapper/carried_watch.hpp>

#include <algorithm>

#include <lcmslam/dense_mapper/free_space.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>

namespace lcmslam {
namespace {

constexpr double longest_frame = 1;  // s that one frame speaks for
constexpr double looks_within = 3;   // m from the camera: farther surfaces are seen at too flat angles

// Share of the map's surfaces in the view that the frame looks through. A prediction that is some centimetres
// off looks through edges and floors as well, so tolerance is wide.
double seen_through(const DenseFrame& frame, const Eigen::Isometry3d& T_world_camera, const VoxelMap& map) {
  constexpr std::size_t enough = 300;  // surfels
  FreeSpaceSettings wide;
  wide.tolerance = 0.25;
  wide.lateral = 0.1;
  const FreeSpaceView view(frame.cloud, wide);
  const Cloud surfels = map.partners_around(T_world_camera.translation(), looks_within);
  const Eigen::Isometry3f T = T_world_camera.inverse().cast<float>();
  std::size_t through = 0, supported = 0;
  for (std::size_t i = 0; i < surfels.size(); ++i) {
    const Visibility seen = view.judge(T * surfels.points[i], T.linear() * surfels.normals[i]);
    through += seen == Visibility::seen_through ? 1 : 0;
    supported += seen == Visibility::supported ? 1 : 0;
  }
  return through + supported < enough
             ? 0
             : static_cast<double>(through) / static_cast<double>(through + supported);
}

}  // namespace

void CarriedWatch::observe(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_predicted,
                           bool placed, bool adrift, const VoxelMap& map) {
  const bool blind = static_cast<int>(prepared.cloud.size()) < settings_.min_points;
  const DenseFrame& frame = prepared.frame;
  const double since = 1e-6 * static_cast<double>(frame.utime - last_utime_);
  const double seconds = last_utime_ == 0 ? 0 : std::min(since, longest_frame);
  last_utime_ = frame.utime;
  if (placed) {
    contradicted_ = unplaced_ = 0;
    carried_ = false;
    T_placed_robot_.setIdentity();
    return;
  }
  if (carried_) {
    unplaced_ += blind ? 0 : seconds;
    return;
  }
  const bool wheels = frame.motion && !frame.motion->visual;
  if (wheels) T_placed_robot_ = T_placed_robot_ * frame.motion->T_from_to;
  if (blind || !wheels) return;
  // Once it was elsewhere, odometry goes on from a wrong place.
  const bool against = contradicted() || (!adrift && is_contradicted(prepared, T_world_predicted, map));
  contradicted_ = against ? contradicted_ + std::max(seconds, 1e-6) : 0;
  carried_ = settings_.carried_after > 0 && contradicted_ >= settings_.carried_after;
}

bool CarriedWatch::is_contradicted(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_predicted,
                                   const VoxelMap& map) const {
  constexpr double most = 0.4;  // share
  if (T_placed_robot_.translation().norm() < settings_.keyframe_distance &&
      rotation_angle(T_placed_robot_) < settings_.keyframe_angle)
    return true;
  return seen_through(prepared.frame, T_world_predicted * prepared.frame.T_robot_camera, map) > most;
}

}  // namespace lcmslam
