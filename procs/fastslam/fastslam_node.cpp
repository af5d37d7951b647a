#include "procs/fastslam/fastslam_node.hpp"

#include <cmath>
#include <thread>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/fastslam/motion_model.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/runtime/arrival.hpp>
#include "procs/fastslam/step_messages.hpp"

namespace lcmslam {
namespace {

constexpr Utime longest_prediction = 1'000'000;  // us that the last velocity goes on without odometry
constexpr Utime longest_gap = 5'000'000;         // us; beyond it the motion is anybody's guess

}  // namespace

FastSlamNodeSettings FastSlamNode::read(const ConfigNode& config) {
  FastSlamNodeSettings settings;
  SettingsReader preset(config);
  settings.describe_preset(preset);
  if (settings.preset == "thesis") settings.filter = thesis_preset();
  return read_settings(config, settings);
}

FastSlamNode::FastSlamNode(const ConfigNode& config, Publisher& publisher)
    : FastSlamNode(read(config), publisher) {}

FastSlamNode::FastSlamNode(const FastSlamNodeSettings& settings, Publisher& publisher)
    : publisher_(publisher),
      settings_(settings.filter),
      pose_(settings.pose),
      frame_queue_(static_cast<std::size_t>(settings.frame_queue)),
      join_(settings.max_wait, std::max<std::size_t>(6, frame_queue_),
            [this](FeatureFrame& frame) { on_features(std::move(frame)); }) {}

void FastSlamNode::connect(Inputs& inputs) {
  inputs
      .subscribe<features_t>("FEATURES", frame_queue_,
                             [this](const features_t& m) {
                               FeatureFrame frame = from_message(m);
                               const Utime needed = frame.utime;
                               join_.add(needed, std::move(frame));
                             })
      .primary = true;
  inputs.subscribe<odometry_t>("ODOMETRY", 500,
                               [this](const odometry_t& m) { join_.add(from_message(m), m.sender); });
}

void FastSlamNode::command(const command_t& command) {
  if (command.name == "resend") publish_whole_map();
  if (command.name == "reset") slam_.reset();
  if (command.name == "smooth" && slam_ && !slam_->smoothing() && !slam_->begin_smoothing())
    publish_smoothed(slam_->smooth());
}

void FastSlamNode::finish() {
  join_.flush();
  if (slam_) publish_smoothed(slam_->smooth());
}

void FastSlamNode::publish_smoothed(const std::vector<SmoothedPose>& path) {
  for (const SmoothedPose& smoothed : path) {
    pose_estimate_t pose =
        make_pose_estimate(smoothed.utime, smoothed.T_world_robot, Matrix6d::Identity() * std::nan(""));
    pose.map_revision = revision_;
    publisher_.publish("FASTSLAM_SMOOTHED", pose);
  }
  publish_changes(last_utime_);
}

void FastSlamNode::start(const FeatureFrame& frame) {
  FastSlamSettings settings = settings_;
  settings.planar = pose_ == "planar" || (pose_ == "auto" && frame.has_mount);
  slam_.emplace(settings);
  revision_ = 0;
}

Motion FastSlamNode::motion_to(Utime utime) const {
  if (const auto motion = join_.motion().between(last_utime_, utime, longest_prediction)) return *motion;
  return unknown_motion(utime - last_utime_);
}

void FastSlamNode::on_features(FeatureFrame frame) {
  const double begin = publisher_.cpu_time();
  const Arrival arrival = arrival_of(frame.utime, last_utime_, longest_gap);
  const bool jumped = arrival == Arrival::jumped;
  if (slam_ && arrival == Arrival::late) return;
  if (slam_ && jumped) ++restarts_;
  // Nothing mapped, and no word on the motion since: the world may as well begin here.
  const bool blank = slam_ && slam_->index().size() == 0 && !join_.motion().covers(last_utime_);
  if (!slam_ || jumped || blank) {
    start(frame);
    last_utime_ = frame.utime;
  }
  last_ = slam_->step(motion_to(frame.utime), frame);
  if (const auto smoothed = slam_->take_smoothed(); !smoothed.empty()) publish_smoothed(smoothed);
  last_utime_ = frame.utime;
  ++steps_;
  lost_ += last_.status == TrackStatus::lost ? 1 : 0;
  publish(frame, last_, publisher_.cpu_time() - begin);
}

void FastSlamNode::publish(const FeatureFrame& frame, const StepResult& result, double cpu_time) {
  pose_estimate_t pose = pose_message(frame.utime, result);
  pose.map_revision = revision_;
  pose.processing_time = cpu_time;
  publisher_.publish("FASTSLAM_POSE", pose);
  publisher_.publish("FASTSLAM_PARTICLES", particles_message(frame.utime, result, *slam_));
  publisher_.publish("FASTSLAM_ASSOCIATIONS", associations_message(frame, result));
  publish_changes(frame.utime);
}

void FastSlamNode::publish_changes(Utime utime) {
  const MapChanges changes = slam_->take_changes();
  if (changes.changed.empty() && changes.removed.empty()) return;
  // A change that needs several tiles goes out as several changes, each on top of the one before.
  for (landmarks_t& tile : make_landmark_tiles(utime, 0, 0, changes.changed, changes.removed)) {
    tile.base_revision = revision_;
    tile.map_revision = ++revision_;
    tile.tile = 0;
    tile.n_tiles = 1;
    publisher_.publish("FASTSLAM_LANDMARKS", tile);
  }
}

void FastSlamNode::publish_whole_map() {
  if (!slam_ || revision_ == 0) return;
  publish_changes(last_utime_);
  for (const landmarks_t& tile : make_landmark_tiles(last_utime_, revision_, 0, slam_->landmarks(), {})) {
    publisher_.publish("FASTSLAM_LANDMARKS", tile);
    std::this_thread::sleep_for(publisher_.pace());
  }
}

NodeReport FastSlamNode::report() const {
  NodeReport report;
  report.values = {{"steps", static_cast<double>(steps_)},
                   {"without_odometry", static_cast<double>(join_.without_odometry())},
                   {"skipped", static_cast<double>(join_.dropped())},
                   {"lost", static_cast<double>(lost_)},
                   {"restarts", static_cast<double>(restarts_)},
                   {"landmarks", slam_ ? static_cast<double>(slam_->index().size()) : 0},
                   {"effective_sample_size", last_.effective_sample_size},
                   {"matched", static_cast<double>(last_.matched)}};
  if (slam_ && slam_->smoothing_cost() > 0)
    report.values.emplace_back("smoothing_cost", slam_->smoothing_cost());
  if (slam_ && settings_.range_offset_sigma + settings_.range_scale_sigma > 0) {
    report.values.emplace_back("range_offset", slam_->sensor_calibration().range_offset);
    report.values.emplace_back("range_scale", slam_->sensor_calibration().range_scale);
    report.values.emplace_back("bearing_offset", slam_->sensor_calibration().bearing_offset);
  }
  return report;
}

}  // namespace lcmslam
