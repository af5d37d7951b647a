#include "procs/map-server/layer_feed.hpp"

#include <algorithm>
#include <cstdlib>

namespace lcmslam {
namespace {

constexpr Utime nearest_frame = 17'000;   // us; half the time between two at 30 Hz
constexpr Utime longest_step = 500'000;   // us between two poses of one motion
constexpr Utime longest_way = 2'000'000;  // us that a keyframe may take to come here
constexpr std::size_t most_frames = 90;   // that wait for their pose or to become keyframes
constexpr std::size_t most_bytes = 64'000'000;
constexpr std::size_t most_poses = 200;
constexpr std::int64_t many_waiting = 32;  // keyframes and corrections, a second's work

std::size_t bytes_of(const EncodedFrame& frame) {
  return frame.colour.bytes.size() + frame.depth.bytes.size() + frame.amplitude.bytes.size();
}

Utime period(double rate) {
  return rate > 0 ? static_cast<Utime>(1e6 / rate) : 0;
}

/// Whether something is due that happens at most once a period; `next` is when it is due again.
bool due(Utime utime, Utime period, Utime& next) {
  if (period == 0 || utime + period / 4 < next) return false;
  next = std::max(next, utime - period) + period;
  return true;
}

}  // namespace

LayerFeed::LayerFeed(const LayerSettings& settings)
    : period_(period(settings.rate)), surface_period_(period(settings.surface_rate)), worker_(settings.map) {}

void LayerFeed::calibrate(const RgbdCalibration& calibration) {
  calibration_ = calibration;
  newest_ = known_.same_as(calibration);
  frames_.clear();
  frame_bytes_ = 0;
  if (!worker_.map()) begin_map();
}

void LayerFeed::begin_map() {
  poses_.clear();
  next_shown_ = next_fused_ = 0;
  if (calibration_) worker_.begin_map(newest_);
}

void LayerFeed::camera(EncodedFrame frame) {
  if (!calibration_) return;
  frame_bytes_ += bytes_of(frame);
  frames_.push_back(std::make_shared<EncodedFrame>(std::move(frame)));
  while (frames_.size() > most_frames || (frame_bytes_ > most_bytes && frames_.size() > 1)) {
    frame_bytes_ -= bytes_of(*frames_.front());
    frames_.pop_front();
  }
}

void LayerFeed::pose(Utime utime, const Eigen::Isometry3d& T_map_robot) {
  if (!poses_.empty() && utime <= poses_.back().first) {  // time began anew
    poses_.clear();
    next_shown_ = next_fused_ = 0;
  }
  poses_.emplace_back(utime, T_map_robot);
  if (poses_.size() > most_poses) poses_.pop_front();
  if (!calibration_) return;
  const LayerWorker::Frame frame = frame_at(utime);
  if (!frame || !due(utime, period_, next_shown_)) return;
  // A mapper's pose is that of the robot when the depth image was taken, which is all that space asks for.
  const Eigen::Isometry3d T_map_camera = T_map_robot * calibration_->T_robot_camera;
  const auto until_colour = motion(utime, frame->utime);
  if (until_colour && due(utime, surface_period_, next_fused_))
    worker_.show({frame, newest_},
                 pose_at_colour(*frame, T_map_robot * *until_colour * calibration_->T_robot_camera), true);
  else
    worker_.show({frame, newest_}, {T_map_camera, Eigen::Isometry3d::Identity()}, false);
}

void LayerFeed::poor_pose(Utime utime, const Eigen::Isometry3d& T_map_robot) {
  if (!calibration_) return;
  const LayerWorker::Frame frame = frame_at(utime);
  if (!frame || !due(utime, period_, next_shown_)) return;
  worker_.glance({frame, newest_},
                 {T_map_robot * calibration_->T_robot_camera, Eigen::Isometry3d::Identity()});
}

/// The one whose depth image was taken then.
LayerWorker::Frame LayerFeed::image_at(Utime colour_time) const {
  const auto found = std::find_if(frames_.rbegin(), frames_.rend(),
                                  [&](const auto& frame) { return frame->colour.utime == colour_time; });
  return found != frames_.rend() ? *found : nullptr;
}

LayerWorker::Frame LayerFeed::frame_at(Utime depth_time) const {
  const auto away = [&](const auto& frame) {
    return std::abs(calibration_->depth_time(frame->depth.utime) - depth_time);
  };
  const auto nearest = std::min_element(frames_.begin(), frames_.end(),
                                        [&](const auto& a, const auto& b) { return away(a) < away(b); });
  return nearest != frames_.end() && away(*nearest) <= nearest_frame ? *nearest : nullptr;
}

FramePose LayerFeed::pose_at_colour(const EncodedFrame& frame, const Eigen::Isometry3d& T_map_camera) const {
  FramePose pose{T_map_camera, Eigen::Isometry3d::Identity()};
  const Eigen::Isometry3d& T_robot_camera = calibration_->T_robot_camera;
  if (const auto T_colour_depth_time = motion(frame.utime, calibration_->depth_time(frame.depth.utime)))
    pose.T_colour_depth_time = T_robot_camera.inverse() * *T_colour_depth_time * T_robot_camera;
  return pose;
}

/// Of the robot, as the poses around `from` tell its velocity.
std::optional<Eigen::Isometry3d> LayerFeed::motion(Utime from, Utime to) const {
  if (poses_.size() < 2) return std::nullopt;
  auto b =
      std::find_if(poses_.begin() + 1, poses_.end(), [&](const auto& pose) { return pose.first >= from; });
  if (b == poses_.end()) --b;
  const auto a = std::prev(b);
  if (b->first - a->first > longest_step || std::abs(from - b->first) > longest_step) return std::nullopt;
  const double share = static_cast<double>(to - from) / static_cast<double>(b->first - a->first);
  return se3_exp(share * se3_log(a->second.inverse() * b->second));
}

/// A keyframe has the time of its colour image, or of depth's where the motion between them was not known.
LayerWorker::Frame LayerFeed::frame_of(const DenseKeyframe& keyframe) const {
  const auto found = std::find_if(frames_.begin(), frames_.end(), [&](const auto& frame) {
    return frame->utime == keyframe.utime || calibration_->depth_time(frame->depth.utime) == keyframe.utime;
  });
  return found != frames_.end() ? *found : nullptr;
}

bool LayerFeed::has_time_for(const DenseKeyframe& keyframe) const {
  return calibration_ && (worker_.state().waiting < many_waiting || frame_of(keyframe));
}

std::optional<StoredImages> LayerFeed::keyframe(const DenseKeyframe& keyframe, const KeptImages& kept) {
  if (!calibration_) return std::nullopt;
  std::optional<StoredImages> images;
  const LayerWorker::Frame frame = frame_of(keyframe);
  LayerWorker::Images shown{frame, newest_};
  FramePose pose{keyframe.T_world_camera, Eigen::Isometry3d::Identity()};
  if (frame) {
    if (keyframe.utime == frame->utime) pose = pose_at_colour(*frame, keyframe.T_world_camera);
    images = StoredImages{*frame, pose.T_colour_depth_time};
    images->frame.amplitude = {};
  } else if (const auto before = kept ? kept() : std::nullopt) {
    shown = {std::make_shared<EncodedFrame>(before->frame), known_.of(*before)};
    pose.T_colour_depth_time = before->T_colour_depth_time;
  }
  const bool is_new = frame || (!poses_.empty() && keyframe.utime > poses_.back().first - longest_way);
  const LiveMap::When when = is_new ? LiveMap::When::now : LiveMap::When::before;
  if (shown.frame && shown.calibration)
    worker_.keep(keyframe.id, shown, pose, when);
  else
    worker_.keep(keyframe.id, keyframe.cloud, keyframe.T_world_camera, when);
  return images;
}

void LayerFeed::adopt(int id, const Eigen::Isometry3d& T_map_camera,
                      const std::optional<StoredImages>& images, ColouredCloud cloud) {
  const LayerWorker::Calibration calibration = images ? known_.of(*images) : nullptr;
  if (!calibration) return worker_.adopt(id, std::move(cloud), T_map_camera);
  worker_.adopt(id, {std::make_shared<EncodedFrame>(images->frame), calibration},
                {T_map_camera, images->T_colour_depth_time});
}

// By the graph, not the map: of that a keyframe may be missing whose images are here.
void LayerFeed::correct(const DenseMap& map, const FollowedGraph& graph) {
  std::map<int, Eigen::Isometry3d> poses;
  for (const auto& [id, keyframe] : map.keyframes()) poses[id] = keyframe.T_world_camera;
  if (!graph.complete()) return worker_.correct(std::move(poses));
  for (const KeyframePose& node : graph.poses()) poses[node.id] = node.T_world_camera;
  worker_.follow(std::move(poses));
}

}  // namespace lcmslam
