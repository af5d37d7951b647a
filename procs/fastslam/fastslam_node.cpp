#include "procs/fastslam/fastslam_node.hpp"

#include <cmath>
#include <thread>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/fastslam/motion_model.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/rgbd/rolling_shutter.hpp>
#include "procs/fastslam/step_messages.hpp"

namespace lcmslam {
namespace {

constexpr Utime longest_prediction = 1'000'000;  // us that the last velocity goes on without odometry
constexpr Utime longest_guess = 60'000'000;      // us: a robot that was away for longer may be anywhere

// Of the part of a motion that odometry has not told. The older a velocity, the less it says of the present
// one, and as old as longest_prediction nothing.
Matrix6d guess_covariance(Utime from, Utime to, Utime newest) {
  const Utime begin = std::max(from, newest);
  if (to <= begin) return Matrix6d::Zero();
  const double age = (0.5 * static_cast<double>(begin - newest + to - newest)) / longest_prediction;
  return age * age * unknown_motion(to - begin).covariance;
}

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
      first_map_frame_(settings.map_frame),
      frame_queue_(static_cast<std::size_t>(settings.frame_queue)),
      new_map_after_(settings.new_map_after),
      new_map_when_carried_(settings.new_map_when_carried),
      join_(settings.max_wait, std::max<std::size_t>(6, frame_queue_),
            [this](const FeatureFrame& frame) { on_features(frame); }) {}

void FastSlamNode::connect(Inputs& inputs) {
  inputs.on_new_session = [this] { begin_session(); };
  inputs
      .subscribe_measured<features_t>("FEATURES", frame_queue_,
                                      [this](const features_t& m) {
                                        FeatureFrame frame = from_message(m);
                                        const Utime needed = frame.utime;
                                        join_.add(needed, std::move(frame));
                                      })
      .primary = true;
  inputs.subscribe_measured<odometry_t>(
      "ODOMETRY", 500, [this](const odometry_t& m) { join_.add(from_message(m), m.sender); });
  inputs.subscribe<camera_calibration_t>(
      "CAMERA_CALIBRATION", 10,
      [this, &inputs](const camera_calibration_t& m) { shutter_.hear(m, inputs.stamps()); });
}

void FastSlamNode::command(const command_t& command) {
  if (command.name == "resend") publish_whole_map();
  if (command.name == "reset") begin_session();
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
    pose.frame = map_frame();
    pose.map_revision = revision_;
    publisher_.publish("FASTSLAM_SMOOTHED", pose);
  }
  publish_changes(last_utime_);
}

// The map that there is stays as it was published, under its own frame.
void FastSlamNode::begin_session() {
  join_.begin_session();
  if (slam_) begin_map_beside();
}

void FastSlamNode::begin_map_beside() {
  publish_changes(last_utime_);
  slam_.reset();
  last_ = {};
  ++session_;
}

// What is seen has contradicted the map for long, or after a gap has told nothing for longer: the robot is
// where it has not been.
bool FastSlamNode::is_elsewhere() const {
  return (new_map_when_carried_ > 0 && last_.unplaced >= new_map_when_carried_) ||
         (new_map_after_ > 0 && last_.adrift >= new_map_after_);
}

void FastSlamNode::start(const FeatureFrame& frame) {
  FastSlamSettings settings = settings_;
  settings.planar = pose_ == "planar" || (pose_ == "auto" && frame.has_mount);
  slam_.emplace(settings);
  revision_ = 0;
}

Motion FastSlamNode::motion_to(Utime utime) const {
  const MotionBuffer& odometry = join_.motion();
  auto motion = odometry.between(last_utime_, utime, longest_prediction);
  if (!motion) return unknown_motion(std::min(utime - last_utime_, longest_guess));
  // Odometry that came late tells by how much the guess was wrong.
  if (guess_ && guess_->sender == join_.sender())
    motion->T_from_to = guess_->T_odom_robot.inverse() * odometry.at(utime, longest_prediction)->T_odom_robot;
  motion->covariance += guess_covariance(last_utime_, utime, odometry.newest());
  return *motion;
}

// What landmarks have put right in the meantime shall not be put right twice.
void FastSlamNode::remember_guess(Utime utime) {
  guess_.reset();
  if (utime <= join_.motion().newest() || last_.used > 0) return;
  if (const auto sample = join_.motion().at(utime, longest_prediction))
    guess_ = Guess{join_.sender(), sample->T_odom_robot};
}

void FastSlamNode::on_features(const FeatureFrame& frame) {
  const double begin = publisher_.cpu_time();
  if (slam_ && frame.utime <= last_utime_) return;
  if (slam_ && is_elsewhere()) begin_map_beside();
  // Nothing mapped, and no word on the motion since: the world may as well begin here.
  const bool blank = slam_ && revision_ == 0 && slam_->index().size() == 0 &&
                     !join_.motion().between(last_utime_, frame.utime, longest_prediction);
  if (!slam_ || blank) {
    const LocalFrame local_frame = slam_ ? slam_->local_frame() : LocalFrame();  // nobody has leapt
    start(frame);
    slam_->go_on_in(local_frame);
    last_utime_ = frame.utime;
  }
  FeatureFrame straight = frame;  // what is published names pixels where they were seen
  straighten_rows(straight, join_.motion(), shutter_.seconds());
  gaps_ += frame.utime - last_utime_ > longest_prediction ? 1 : 0;
  last_ = slam_->step(motion_to(frame.utime), straight);
  if (const auto smoothed = slam_->take_smoothed(); !smoothed.empty()) publish_smoothed(smoothed);
  last_utime_ = frame.utime;
  remember_guess(frame.utime);
  ++steps_;
  lost_ += last_.status == TrackStatus::lost ? 1 : 0;
  off_ground_ += last_.floor != Floor::plane ? 1 : 0;
  publish(frame, last_, publisher_.cpu_time() - begin);
}

void FastSlamNode::publish(const FeatureFrame& frame, const StepResult& result, double cpu_time) {
  pose_estimate_t pose = pose_message(frame.utime, result);
  pose.frame = map_frame();
  if (result.unplaced > 0) add_detail(pose.detail, "what is seen contradicts the map");
  add_detail(pose.detail, unplaced_map(pose.frame));
  pose.map_revision = revision_;
  pose.processing_time = cpu_time;
  publisher_.publish("FASTSLAM_POSE", pose);
  const std::string local_frame = local_frame_of(pose.frame);
  publisher_.publish("FASTSLAM_LOCAL_POSE", local_pose_message(pose, result, local_frame));
  publisher_.publish("FASTSLAM_CORRECTION", correction_message(pose, result, local_frame));
  particles_t particles = particles_message(frame.utime, result, *slam_);
  particles.frame = map_frame();
  publisher_.publish("FASTSLAM_PARTICLES", particles);
  publisher_.publish("FASTSLAM_ASSOCIATIONS", associations_message(frame, result));
  publish_changes(frame.utime);
}

void FastSlamNode::publish_changes(Utime utime) {
  const MapChanges changes = slam_->take_changes();
  if (changes.changed.empty() && changes.removed.empty()) return;
  // A change that needs several tiles goes out as several changes, each on top of the one before.
  for (landmarks_t& tile : make_landmark_tiles(utime, 0, 0, changes.changed, changes.removed)) {
    tile.frame = map_frame();
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
  for (landmarks_t& tile : make_landmark_tiles(last_utime_, revision_, 0, slam_->landmarks(), {})) {
    tile.frame = map_frame();
    publisher_.publish("FASTSLAM_LANDMARKS", tile);
    std::this_thread::sleep_for(publisher_.pace());
  }
}

NodeReport FastSlamNode::report() const {
  NodeReport report;
  report.detail = unplaced_map(map_frame());
  report.values = {{"steps", static_cast<double>(steps_)},
                   {"without_odometry", static_cast<double>(join_.without_odometry())},
                   {"skipped", static_cast<double>(join_.dropped())},
                   {"lost", static_cast<double>(lost_)},
                   {"off_ground", static_cast<double>(off_ground_)},
                   {"sessions", static_cast<double>(session_)},
                   {"gaps", static_cast<double>(gaps_)},
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
