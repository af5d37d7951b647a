#include <lcmslam/dense_mapper/carried_watch.hpp>

#include <Eigen/Dense>
#include <algorithm>

#include <lcmslam/dense_mapper/contradiction.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>

namespace lcmslam {
namespace {

constexpr double longest_frame = 1;  // s that one frame speaks for

/// Where odometry has led the camera.
Eigen::Isometry3d T_world_camera(const DenseFrame& frame, const Tracked& tracked) {
  return tracked.prior.T_target_source * frame.T_robot_camera;
}

// After a long way by wheels alone who looks through the map is beside the place where he is thought to be.
bool is_certain(const Prior& prior) {
  constexpr double most = 0.15;  // m, standard deviation
  const Eigen::Matrix2d variances = prior.information.inverse().topLeftCorner<2, 2>();
  return variances.trace() < most * most;
}

}  // namespace

void CarriedWatch::observe(const PreparedFrame& prepared, const Tracked& tracked, bool placed, bool adrift,
                           const VoxelMap& map) {
  const bool blind = static_cast<int>(prepared.cloud.size()) < settings_.min_points;
  const DenseFrame& frame = prepared.frame;
  const double since = 1e-6 * static_cast<double>(frame.utime - last_utime_);
  const double seconds = last_utime_ == 0 ? 0 : std::min(since, longest_frame);
  last_utime_ = frame.utime;
  blocked_ = false;
  if (placed) {
    contradicted_ = unplaced_ = 0;
    carried_ = false;
    T_placed_robot_.setIdentity();
    return;
  }
  if (carried_) {
    const bool fits = tracked.status == MappingStatus::tracking;
    unplaced_ += blind || fits ? 0 : seconds;
    return;
  }
  const bool wheels = frame.motion && !frame.motion->visual;
  if (wheels) T_placed_robot_ = T_placed_robot_ * frame.motion->T_from_to;
  // What cameras see tells nothing of who is carried, nor does what goes with the robot.
  if ((frame.motion && !wheels) || tracked.held) contradicted_ = 0;
  if (blind || !wheels || tracked.held) return;
  blocked_ = !adrift && is_about_there() && hides_the_map(frame, T_world_camera(frame, tracked), map);
  if (blocked_) return;
  // Once it was elsewhere, odometry goes on from a wrong place.
  const bool against = contradicted() || (!adrift && is_contradicted(prepared, tracked, map));
  contradicted_ = against ? contradicted_ + std::max(seconds, 1e-6) : 0;
  carried_ = contradicted() && contradicted_ >= settings_.carried_after;
}

bool CarriedWatch::is_contradicted(const PreparedFrame& prepared, const Tracked& tracked,
                                   const VoxelMap& map) const {
  constexpr double most = 0.4;  // share
  const Eigen::Isometry3d& T_world_predicted = tracked.prior.T_target_source;
  if (still_shows(prepared.cloud, T_world_predicted, tracked.registration.T_target_source, map)) return false;
  return is_about_there() ||
         (is_certain(tracked.prior) &&
          seen_through(prepared.frame, T_world_camera(prepared.frame, tracked), map) > most);
}

bool CarriedWatch::is_about_there() const {
  return T_placed_robot_.translation().norm() < settings_.keyframe_distance &&
         rotation_angle(T_placed_robot_) < settings_.keyframe_angle;
}

}  // namespace lcmslam
