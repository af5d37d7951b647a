#include "procs/icp/icp_node.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <thread>
#include <utility>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/rgbd/feature_depth.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include <lcmslam/rgbd/rolling_shutter.hpp>
#include "procs/icp/icp_messages.hpp"

namespace lcmslam {
namespace {

constexpr Utime longest_gap = 5'000'000;  // us
constexpr Utime same_moment = 1000;       // us
constexpr std::size_t features_kept = 8;  // frames; odometry may lag behind features

}  // namespace

IcpNodeSettings IcpNode::read(const ConfigNode& config) {
  return read_settings<IcpNodeSettings>(config);
}

IcpNode::IcpNode(const ConfigNode& config, Publisher& publisher) : IcpNode(read(config), publisher) {}

IcpNode::IcpNode(const IcpNodeSettings& settings, Publisher& publisher)
    : publisher_(publisher),
      settings_(settings.mapper),
      filter_settings_(settings.depth_filter),
      pose_(settings.pose),
      cloud_points_(settings.cloud_points),
      frame_queue_(static_cast<std::size_t>(settings.frame_queue)),
      join_(
          settings.max_wait, std::max<std::size_t>(6, frame_queue_),
          [this](Prepared& prepared) { on_frame(prepared); }, settings.extrapolation),
      readout_(settings.rolling_shutter),
      rolling_sensors_(settings.rolling_sensors),
      depth_clock_(settings_.depth_clock) {}

void IcpNode::connect(Inputs& inputs) {
  inputs.subscribe<images_t>("CAMERA", frame_queue_, [this](const images_t& m) { on_camera(m); }).primary =
      true;
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10,
                                         [this](const camera_calibration_t& m) { on_calibration(m); });
  inputs.subscribe<features_t>("FEATURES", frame_queue_, [this](const features_t& m) { on_features(m); });
  inputs.subscribe<odometry_t>("ODOMETRY", 500,
                               [this](const odometry_t& m) { join_.add(from_message(m), m.sender); });
}

void IcpNode::on_camera(const images_t& message) {
  if (!calibration_) {
    uncalibrated_ = message;
    return;
  }
  // Odometry comes later: what needs no motion is done while it is made.
  EncodedFrame encoded = checked_images(message, *calibration_);
  Prepared prepared;
  const bool colour_later =
      settings_.variant == VariantKind::modern && !settings_.uses_colour() && !settings_.compares_images();
  if (colour_later) prepared.colour = std::exchange(encoded.colour, {});
  prepared.frame = decode_images(encoded, *calibration_);
  RgbdFrame& frame = prepared.frame;
  if (!frame.depth.empty()) (*filter_)(frame.depth, frame.amplitude);
  const double pixels = static_cast<double>(frame.depth.total());
  const int step = std::max(1, static_cast<int>(std::lround(std::sqrt(pixels / cloud_points_))));
  prepared.view = prepared_view(*registration_, frame, step);
  const Utime depth_utime = calibration_->depth_time(frame.depth_utime);
  const Utime needed = std::max({frame.utime, depth_utime, depth_utime + clock_correction()});
  join_.add(needed, std::move(prepared));
}

void IcpNode::on_calibration(const camera_calibration_t& message) {
  if (calibration_ && same_calibration(message, calibration_message_)) return;
  const RgbdCalibration calibration = from_message(message);
  join_.flush();  // frames of the old one
  calibration_message_ = message;
  calibration_ = calibration;
  registration_.emplace(calibration);
  const bool rolling = std::count(rolling_sensors_.begin(), rolling_sensors_.end(), calibration.sensor) > 0;
  rolling_shutter_ = rolling ? readout_ : 0;
  filter_.emplace(calibration, filter_settings_);
  settings_.prior.planar = pose_ == "planar" || (pose_ == "auto" && calibration.has_mount);
  if (uncalibrated_) on_camera(*std::exchange(uncalibrated_, std::nullopt));
}

// Those of a keyframe are welcome after its step, too.
void IcpNode::on_features(const features_t& message) {
  features_.push_back(from_message(message));
  while (features_.size() > features_kept) features_.pop_front();
  if (mapper_) mapper_->add_features(features_.back(), features_.back().utime);
}

Utime IcpNode::clock_correction() const {
  return static_cast<Utime>(std::lround(1e6 * depth_clock_.offset()));
}

void IcpNode::observe_clock(const Shot& shot, const std::optional<Motion>& motion) {
  const double seconds = 1e-6 * static_cast<double>(shot.utime - last_utime_);
  if (!last_.anchored || last_.status != MappingStatus::tracking || !motion || !(seconds > 0)) return;
  const Eigen::Vector3d omega = so3_log(motion->T_from_to.linear()) / seconds;
  depth_clock_.add(last_.T_world_anchor, last_.T_world_robot, omega);
}

void IcpNode::restart() {
  mapper_.emplace(settings_);
  tiles_.clear();
  last_ = {};
}

IcpNode::Shot IcpNode::make_shot(const Prepared& prepared) const {
  const RgbdFrame& frame = prepared.frame;
  Shot shot;
  shot.depth_utime = calibration_->depth_time(frame.depth_utime);
  const Utime seen_utime = shot.depth_utime + clock_correction();
  // Images of one moment need no motion.
  const bool together = std::abs(frame.utime - seen_utime) < same_moment;
  const auto motion = together ? std::nullopt : join_.between(frame.utime, seen_utime);
  const auto told = join_.between(frame.utime, shot.depth_utime);
  shot.utime = together || (motion && told) ? frame.utime : shot.depth_utime;
  if (shot.utime == frame.utime && told) shot.T_points_depth = told->T_from_to;
  const Eigen::Isometry3d& T_robot_camera = calibration_->T_robot_camera;
  if (motion) shot.T_colour_depth_time = T_robot_camera.inverse() * motion->T_from_to * T_robot_camera;
  shot.joined = motion && told;
  const auto turn = rolling_shutter_ > 0 ? join_.between(last_utime_, frame.utime) : std::nullopt;
  if (turn && frame.utime > last_utime_) {
    const double seconds = 1e-6 * static_cast<double>(frame.utime - last_utime_);
    shot.camera_twist = se3_log(T_robot_camera.inverse() * turn->T_from_to * T_robot_camera) / seconds;
  }
  shot.cloud = cloud_of(prepared.view, shot.T_colour_depth_time, rolling_shutter_ * shot.camera_twist);
  return shot;
}

// For keyframes: few, so that colour is decoded and looked up here alone.
ColouredCloud IcpNode::paint(Prepared& prepared, const Shot& shot) {
  RgbdFrame& frame = prepared.frame;
  const int step = prepared.view.step;
  bool damaged = false;
  try {
    if (frame.colour.empty()) frame.colour = decode_colour(prepared.colour);
  } catch (const CodecError&) {
    damaged = true;
    ++unpainted_;
  }
  RegisteredDepth depth = (*registration_)(frame, shot.T_colour_depth_time, step);
  straighten_rows(depth.points, rolling_shutter_ * shot.camera_twist);
  return make_cloud(frame, depth, step, damaged);
}

// The same points, but for those that the colour camera does not see.
void IcpNode::add_intensities(Prepared& prepared, Shot& shot) {
  const ColouredCloud painted = paint(prepared, shot);
  shot.cloud = geometry_of(painted);
  shot.cloud.intensities = intensities_of(painted);
}

// Only what is there already: waiting for features would add their latency to the pose's.
std::optional<FeatureFrame> IcpNode::features_at(const Prepared& prepared, const Shot& shot) const {
  const Utime utime = prepared.frame.utime;
  if (std::abs(shot.utime - utime) > same_moment)
    return std::nullopt;  // the cloud stands at another moment than the colour image
  for (const FeatureFrame& frame : features_)
    if (frame.utime == utime) {
      FeatureFrame placed = frame;
      if (shot.joined) {
        const RgbdCalibration& c = registration_->calibration();
        placed =
            placed_by(prepared.view.depth, c.depth, (shot.T_colour_depth_time * c.T_colour_depth).inverse(),
                      frame, shot.T_colour_depth_time);
      }
      straighten_rows(placed, rolling_shutter_ * shot.camera_twist);
      return placed;
    }
  return std::nullopt;
}

void IcpNode::on_frame(Prepared& prepared) {
  const RgbdFrame& frame = prepared.frame;
  const double begin = publisher_.cpu_time();
  Shot shot = make_shot(prepared);
  if (mapper_ && shot.utime <= last_utime_ && last_utime_ - shot.utime < 1'000'000) return;  // came too late
  const bool jumped = shot.utime <= last_utime_ || shot.utime - last_utime_ > longest_gap;
  if (mapper_ && jumped) ++restarts_;
  if (!mapper_ || jumped) {
    restart();
    last_utime_ = shot.utime;
  }
  const auto motion = join_.between(last_utime_, shot.utime);
  T_world_previous_ = last_.T_world_robot;
  if (settings_.uses_colour()) add_intensities(prepared, shot);
  const auto features = features_at(prepared, shot);
  with_features_ += features ? 1 : 0;
  const ColourView colour{frame.colour, calibration_->colour, calibration_->depth,
                          calibration_->T_colour_depth};
  last_ = mapper_->step(
      shot.utime, shot.cloud, [&] { return paint(prepared, shot); }, calibration_->T_robot_camera, motion,
      features ? &*features : nullptr, &colour);
  observe_clock(shot, motion);
  last_utime_ = shot.utime;
  anchored_ += last_.anchored ? 1 : 0;
  ++steps_;
  lost_ += last_.status == MappingStatus::lost ? 1 : 0;
  publish(frame.utime, shot, motion, publisher_.cpu_time() - begin);
}

void IcpNode::publish(Utime frame_utime, const Shot& shot, const std::optional<Motion>& motion,
                      double cpu_time) {
  const IcpMapper::Step& step = last_;
  // First the graph: the pose stands in the map that it makes.
  if (step.thinned) drop_tiles_of_the_gone();
  if (step.node || step.bent || step.thinned) publish_graph();
  pose_estimate_t pose = icp_pose(step, shot.depth_utime, shot.T_points_depth);
  pose.map_revision = mapper_->keyframes_made();
  pose.processing_time = cpu_time;
  publisher_.publish("ICP_POSE", pose, frame_utime);

  std::optional<Eigen::Isometry3d> correction;
  if (motion && !step.bent)
    correction = (T_world_previous_ * motion->T_from_to).inverse() * step.T_world_robot;
  icp_report_t report = icp_report(step, settings_, correction);
  report.utime = shot.depth_utime;
  report.source_points = static_cast<int32_t>(shot.cloud.size());
  report.target_points = static_cast<int32_t>(mapper_->map().size());
  report.processing_time = cpu_time;
  publisher_.publish("ICP_REPORT", report);

  if (step.keyframe) queue_keyframe(mapper_->keyframes().back());
  queue_changed(false);
}

void IcpNode::queue_changed(bool all) {
  for (const std::size_t i : mapper_->take_changed(all)) queue_keyframe(mapper_->keyframes()[i]);
}

void IcpNode::queue_keyframe(const IcpMapper::Keyframe& keyframe) {
  const int id = mapper_->graph().nodes()[static_cast<std::size_t>(keyframe.id)].id;
  const DenseKeyframe dense{id, keyframe.utime, keyframe.T_world_camera, keyframe.cloud};
  ++tellings_;
  for (auto& tile : make_keyframe_tiles(dense, calibration_->T_robot_camera, tellings_))
    tiles_.push_back(std::move(tile));
}

void IcpNode::publish_graph() {
  graph_t graph = icp_graph(mapper_->graph());
  graph.utime = last_utime_;
  graph.map_revision = static_cast<std::int64_t>(mapper_->keyframes().size());
  publisher_.publish("ICP_GRAPH", graph);
}

void IcpNode::drop_tiles_of_the_gone() {
  std::set<std::int32_t> ids;
  for (const auto& node : mapper_->graph().nodes()) ids.insert(node.id);
  tiles_.erase(std::remove_if(tiles_.begin(), tiles_.end(),
                              [&](const keyframe_t& tile) { return ids.count(tile.id) == 0; }),
               tiles_.end());
}

void IcpNode::send_waiting_tile() {
  publisher_.publish("ICP_KEYFRAME", tiles_.front());
  tiles_.pop_front();
}

std::optional<Node::Duration> IcpNode::work() {
  const auto pace = publisher_.pace();
  while (!tiles_.empty() && pace.count() == 0) send_waiting_tile();
  if (tiles_.empty()) return std::nullopt;
  const auto now = std::chrono::steady_clock::now();
  if (now >= next_tile_) {
    send_waiting_tile();
    next_tile_ = now + pace;
  }
  return pace;
}

void IcpNode::command(const command_t& command) {
  if (command.name == "resend" && mapper_ && tiles_.empty()) {  // else what waits is under way already
    for (const auto& keyframe : mapper_->keyframes()) queue_keyframe(keyframe);
    publish_graph();
  }
  if (command.name == "reset") mapper_.reset();
}

void IcpNode::finish() {
  join_.flush();
  if (mapper_ && mapper_->finish()) publish_graph();
  if (mapper_) queue_changed(true);
  while (!tiles_.empty()) {
    send_waiting_tile();
    std::this_thread::sleep_for(publisher_.pace());
  }
}

NodeReport IcpNode::report() const {
  NodeReport report;
  if (!calibration_) report.detail = "waits for CAMERA_CALIBRATION";
  report.values = {{"steps", static_cast<double>(steps_)},
                   {"without_odometry", static_cast<double>(join_.without_odometry())},
                   {"with_features", static_cast<double>(with_features_)},
                   {"anchored", static_cast<double>(anchored_)},
                   {"skipped", static_cast<double>(join_.dropped())},
                   {"lost", static_cast<double>(lost_)},
                   {"unpainted", static_cast<double>(unpainted_)},
                   {"restarts", static_cast<double>(restarts_)},
                   {"keyframes", mapper_ ? static_cast<double>(mapper_->keyframes().size()) : 0},
                   {"map_points", mapper_ ? static_cast<double>(mapper_->map().size()) : 0},
                   {"memory_mb", mapper_ ? 1e-6 * static_cast<double>(mapper_->memory_bytes()) : 0},
                   {"overlap", last_.registration.overlap},
                   {"graph_nodes", mapper_ ? static_cast<double>(mapper_->graph().nodes().size()) : 0},
                   {"graph_edges", mapper_ ? static_cast<double>(mapper_->graph().edges().size()) : 0},
                   {"depth_clock_offset", depth_clock_.offset()},
                   {"depth_clock_sigma", depth_clock_.sigma()}};
  return report;
}

}  // namespace lcmslam
