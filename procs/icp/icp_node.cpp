#include "procs/icp/icp_node.hpp"

#include <algorithm>
#include <utility>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/dense_mapper/thesis/thesis_tracker.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "procs/icp/icp_messages.hpp"
#include "procs/told_calibration.hpp"

namespace lcmslam {
namespace {

constexpr Utime long_pause = 1'000'000;  // us between two frames: a gap

RgbdFrameMakerSettings frame_settings(const IcpNodeSettings& settings) {
  RgbdFrameMakerSettings s;
  s.depth_filter = settings.depth_filter;
  s.range_error = settings.range_error;
  s.depth_clock = settings.mapper.depth_clock;
  s.cloud_points = settings.cloud_points;
  s.keyframe_points = settings.keyframe_pixels;
  s.intensities = settings.mapper.uses_colour();
  if (needs_features(settings.mapper.variant, settings.mapper.thesis))
    s.features_within = settings.mapper.thesis.features_within;
  return s;
}

/// s that a frame waits for its features: what becomes of it shall not depend on whether odometry or they
/// came first.
double features_wait(const DenseMapperSettings& settings) {
  if (needs_features(settings.variant, settings.thesis)) return settings.thesis.features_wait;
  return settings.features.enabled ? settings.features.wait : 0;
}

/// Frames that may wait for odometry, or for their features at 60 Hz.
std::size_t waiting_frames(const IcpNodeSettings& settings) {
  const double features = 60 * features_wait(settings.mapper);
  return static_cast<std::size_t>(std::max({6.0, features, static_cast<double>(settings.frame_queue)}));
}

/// Whether only keyframes show their colours.
bool colour_can_wait(const DenseMapperSettings& s) {
  return s.variant == VariantKind::modern && !s.uses_colour() && !s.compares_images();
}

}  // namespace

IcpNodeSettings IcpNode::read(const ConfigNode& config) {
  return read_settings<IcpNodeSettings>(config);
}

IcpNode::IcpNode(const ConfigNode& config, Publisher& publisher) : IcpNode(read(config), publisher) {}

IcpNode::IcpNode(const IcpNodeSettings& settings, Publisher& publisher)
    : publisher_(publisher),
      settings_(settings.mapper),
      pose_(settings.pose),
      first_map_frame_(settings.map_frame),
      frame_queue_(static_cast<std::size_t>(settings.frame_queue)),
      new_map_after_(settings.new_map_after),
      new_map_when_carried_(settings.new_map_when_carried),
      maker_(frame_settings(settings)),
      join_(
          settings.max_wait, waiting_frames(settings), [this](Prepared& prepared) { on_frame(prepared); },
          settings.extrapolation) {
  const bool always = needs_features(settings_.variant, settings_.thesis);
  if (const double wait = features_wait(settings_); wait > 0)
    join_.need(
        [this, always](const Prepared& prepared) {
          return !maker_.awaits_features(prepared) || !(always || maker_.hears_features(prepared));
        },
        wait);
}

void IcpNode::connect(Inputs& inputs) {
  inputs.on_new_session = [this] { begin_session(); };
  stamps_ = &inputs.stamps();
  inputs.subscribe_measured<images_t>("CAMERA", frame_queue_, [this](const images_t& m) { on_camera(m); })
      .primary = true;
  inputs.subscribe<camera_calibration_t>("CAMERA_CALIBRATION", 10,
                                         [this](const camera_calibration_t& m) { on_calibration(m); });
  inputs.subscribe_measured<features_t>("FEATURES", frame_queue_,
                                        [this](const features_t& m) { on_features(m); });
  inputs.subscribe_measured<odometry_t>(
      "ODOMETRY", 500, [this](const odometry_t& m) { join_.add(from_message(m), m.sender); });
}

void IcpNode::on_calibration(const camera_calibration_t& message) {
  if (maker_.calibrated() && is_of_another_camera(message.sender, calibration_message_.sender, *stamps_))
    return;
  if (maker_.calibrated() && same_calibration(message, calibration_message_)) {
    calibration_message_.sender = message.sender;
    return;
  }
  const RgbdCalibration calibration = told_calibration(message);
  join_.flush();  // frames of the old one
  const bool planar = pose_ == "planar" || (pose_ == "auto" && calibration.has_mount);
  // A map stands on the ground by its camera's mount: with another one, another map begins.
  if (mapper_ && (planar != settings_.prior.planar ||
                  !calibration.T_robot_camera.isApprox(maker_.calibration().T_robot_camera, 1e-9)))
    begin_map_beside();
  maker_.calibrate(calibration);
  calibration_message_ = message;
  settings_.prior.planar = planar;
  if (uncalibrated_) on_camera(*std::exchange(uncalibrated_, std::nullopt));
}

// Odometry comes later: what needs no motion is done while it is made.
void IcpNode::on_camera(const images_t& message) {
  if (!maker_.calibrated()) {
    uncalibrated_ = message;
    return;
  }
  EncodedFrame encoded = checked_images(message, maker_.calibration());
  RgbdFrameMaker::LateColour late_colour;
  if (colour_can_wait(settings_)) late_colour = late(std::exchange(encoded.colour, {}));
  Prepared prepared = maker_.prepare(decode_images(encoded, maker_.calibration()), std::move(late_colour));
  const Utime needed = prepared.needed;
  join_.add(needed, std::move(prepared));
}

RgbdFrameMaker::LateColour IcpNode::late(EncodedImage image) {
  return [this, image = std::move(image)] {
    try {
      return decode_colour(image);
    } catch (const CodecError&) {
      ++uncoloured_;
      return cv::Mat();
    }
  };
}

// Those of a keyframe are welcome after its step, too.
void IcpNode::on_features(const features_t& message) {
  FeatureFrame features = from_message(message);
  if (mapper_) mapper_->add_features(features, features.utime);
  maker_.add(std::move(features));
  join_.look();
}

void IcpNode::on_frame(Prepared& prepared) {
  const double begin = publisher_.cpu_time();
  RgbdFrameMaker::Made made = maker_.make(
      prepared, [this](Utime from, Utime to) { return join_.between(from, to); }, last_utime_);
  DenseFrame& frame = made.frame;
  if (mapper_ && frame.utime <= last_utime_) return;
  if (mapper_ && is_elsewhere()) begin_map_beside();
  if (!mapper_) {
    mapper_.emplace(settings_);
    last_ = {};
    last_utime_ = frame.utime;
  }
  gaps_ += frame.utime - last_utime_ > long_pause ? 1 : 0;
  frame.motion = join_.between(last_utime_, frame.utime);
  with_features_ += frame.features ? 1 : 0;
  without_features_ += !frame.features && needs_features(settings_.variant, settings_.thesis) ? 1 : 0;
  T_world_previous_ = last_.T_world_robot;
  const bool searched = last_.adrift;
  last_ = mapper_->step(frame);
  const double seconds = 1e-6 * static_cast<double>(frame.utime - last_utime_);
  look_for_place(searched, seconds);
  learn_clock(made);
  twist_ = Vector6d::Zero();
  if (frame.motion && seconds > 0) twist_ = se3_log(frame.motion->T_from_to) / seconds;
  last_utime_ = frame.utime;
  anchored_ += last_.anchored ? 1 : 0;
  ++steps_;
  lost_ += last_.status == MappingStatus::lost ? 1 : 0;
  blind_ += last_.blind ? 1 : 0;
  off_ground_ += last_.floor != Floor::plane ? 1 : 0;
  publish(prepared.frame.utime, made, publisher_.cpu_time() - begin);
}

// The map that there is stays as it was published, under its own frame; what of it still waits goes out.
void IcpNode::begin_session() {
  join_.begin_session();
  maker_.forget_features();
  if (mapper_) begin_map_beside();
}

void IcpNode::begin_map_beside() {
  finish_map();
  mapper_.reset();
  keyframe_teller_.begin_map();
  ++session_;
}

// Frames that show something are looks; a camera that was away or covered has not looked.
void IcpNode::look_for_place(bool searched, double seconds) {
  constexpr double longest_frame = 1;  // s that one frame speaks for
  if (!last_.adrift || !searched) searched_ = 0;
  if (last_.adrift && searched && !last_.blind) searched_ += std::min(seconds, longest_frame);
}

// After a gap, or where what it sees contradicts its wheels, the robot may have been carried out of its map.
bool IcpNode::is_elsewhere() const {
  if (new_map_when_carried_ > 0 && last_.unplaced >= new_map_when_carried_) return true;
  return new_map_after_ > 0 && last_.adrift && !last_.carried && searched_ > new_map_after_;
}

void IcpNode::finish_map() {
  mapper_->finish();
  keyframe_teller_.move(map());
  if (!mapper_->graph().nodes().empty()) publish_graph(true);
  keyframe_teller_.tell_changed(map(), true);
}

void IcpNode::learn_clock(const RgbdFrameMaker::Made& made) {
  const DenseFrame& frame = made.frame;
  if (!last_.anchored || last_.status != MappingStatus::tracking || !frame.motion) return;
  maker_.observe(last_.T_world_anchor, last_.T_world_robot, *frame.motion,
                 1e-6 * static_cast<double>(frame.utime - last_utime_), made.added_to_depth);
}

void IcpNode::publish(Utime image_utime, const RgbdFrameMaker::Made& made, double cpu_time) {
  const DenseMapper::Step& step = last_;
  const std::optional<Motion>& motion = made.frame.motion;
  // First the graph: the pose stands in the map that it makes.
  if (step.thinned) keyframe_teller_.drop_the_gone(map());
  if (step.deformed) keyframe_teller_.move(map());
  if (step.node || step.deformed || step.thinned) publish_graph(false);
  pose_estimate_t pose = icp_pose(step, made.depth_utime, made.T_frame_depth,
                                  std::hypot(maker_.depth_clock().sigma(), settings_.stamp_sigma) * twist_);
  pose.frame = map_frame();
  if (step.hangs_on_odometry) add_detail(pose.detail, "this part of the map hangs on odometry alone");
  if (step.floor != Floor::plane) add_detail(pose.detail, "the floor is not flat here");
  if (step.blocked) add_detail(pose.detail, "something close hides what the map shows here");
  if (step.held)
    add_detail(pose.detail,
               "new things stand still in the view though the wheels turn: they go along, or wheels spin");
  if (step.blind) add_detail(pose.detail, "the depth image shows too little");
  if (step.unplaced > 0) add_detail(pose.detail, "carried out of the map: what is seen has no place in it");
  add_detail(pose.detail, unplaced_map(pose.frame));
  pose.map_revision = mapper_->keyframes_made();
  pose.processing_time = cpu_time;
  publisher_.publish("ICP_POSE", pose, image_utime);
  const std::string local_frame = local_frame_of(pose.frame);
  publisher_.publish("ICP_LOCAL_POSE", icp_local_pose(pose, step, made.T_frame_depth, local_frame));
  publisher_.publish("ICP_CORRECTION", icp_correction(pose, step, local_frame));

  std::optional<Eigen::Isometry3d> correction;
  if (motion && !step.deformed)
    correction = (T_world_previous_ * motion->T_from_to).inverse() * step.T_world_robot;
  icp_report_t report = icp_report(step, settings_, correction);
  report.utime = made.depth_utime;
  report.source_points = static_cast<int32_t>(made.frame.cloud.size());
  report.target_points = static_cast<int32_t>(mapper_->map().size());
  report.processing_time = cpu_time;
  publisher_.publish("ICP_REPORT", report);

  if (step.keyframe) keyframe_teller_.tell(map(), mapper_->keyframes().back());
  keyframe_teller_.tell_changed(map(), false);
}

// What changed, or `all` of it: at a map's end, and for whoever asked.
void IcpNode::publish_graph(bool all) {
  graph_t graph = icp_graph(mapper_->graph());
  graph.utime = last_utime_;
  graph.frame = map_frame();
  graph.map_revision = static_cast<std::int64_t>(mapper_->keyframes().size());
  const graph_t told = graph_teller_.tell(std::move(graph), all);
  publisher_.publish("ICP_GRAPH", told);
  if (told.nodes.empty()) return;
  publisher_.publish("ICP_GRAPH_COVARIANCE",
                     icp_graph_covariance(*mapper_, told, maker_.calibration().T_robot_camera));
}

std::optional<Node::Duration> IcpNode::work() {
  return keyframe_teller_.work();
}

void IcpNode::command(const command_t& command) {
  if (command.name == "resend" && mapper_) {
    keyframe_teller_.tell_all(map());
    publish_graph(true);
  }
  if (command.name == "reset") begin_session();
}

void IcpNode::finish() {
  join_.flush();
  if (mapper_) finish_map();
  keyframe_teller_.finish();
}

NodeReport IcpNode::report() const {
  NodeReport report;
  report.detail = maker_.calibrated() ? unplaced_map(map_frame()) : "waits for CAMERA_CALIBRATION";
  report.values = {{"steps", static_cast<double>(steps_)},
                   {"without_odometry", static_cast<double>(join_.without_odometry())},
                   {"with_features", static_cast<double>(with_features_)},
                   {"without_features", static_cast<double>(without_features_)},
                   {"anchored", static_cast<double>(anchored_)},
                   {"skipped", static_cast<double>(join_.dropped())},
                   {"lost", static_cast<double>(lost_)},
                   {"blind", static_cast<double>(blind_)},
                   {"off_ground", static_cast<double>(off_ground_)},
                   {"unpainted", static_cast<double>(uncoloured_)},
                   {"sessions", static_cast<double>(session_)},
                   {"gaps", static_cast<double>(gaps_)},
                   {"keyframes", mapper_ ? static_cast<double>(mapper_->keyframes().size()) : 0},
                   {"map_points", mapper_ ? static_cast<double>(mapper_->map().size()) : 0},
                   {"memory_mb", mapper_ ? 1e-6 * static_cast<double>(mapper_->memory_bytes()) : 0},
                   {"overlap", last_.registration.overlap},
                   {"graph_nodes", mapper_ ? static_cast<double>(mapper_->graph().nodes().size()) : 0},
                   {"graph_edges", mapper_ ? static_cast<double>(mapper_->graph().edges().size()) : 0},
                   {"range_error", maker_.range_error() ? maker_.range_error()->largest() : 0},
                   {"depth_clock_offset", maker_.depth_clock().offset()},
                   {"depth_clock_sigma", maker_.depth_clock().sigma()}};
  return report;
}

}  // namespace lcmslam
