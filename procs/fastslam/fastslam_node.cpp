#include "procs/fastslam/fastslam_node.hpp"

#include <thread>

#include <lcmslam/associations_t.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/particles_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/arrival.hpp>
#include "procs/fastslam/read_settings.hpp"

namespace lcmslam {
namespace {

constexpr Utime longest_prediction = 1'000'000;  // us that the last velocity goes on without odometry
constexpr Utime longest_gap = 5'000'000;         // us; beyond it the motion is anybody's guess

std::int8_t wire_status(TrackStatus status) {
  switch (status) {
    case TrackStatus::initialising:
      return pose_estimate_t::INITIALISING;
    case TrackStatus::tracking:
      return pose_estimate_t::TRACKING;
    case TrackStatus::predicting:
      return pose_estimate_t::DEGRADED;
    case TrackStatus::lost:
      return pose_estimate_t::LOST;
    case TrackStatus::relocalised:
      return pose_estimate_t::RELOCALISED;
  }
  return pose_estimate_t::LOST;
}

std::int8_t wire_outcome(AssociationOutcome outcome) {
  switch (outcome) {
    case AssociationOutcome::accepted:
      return association_t::ACCEPTED;
    case AssociationOutcome::unused:
      return association_t::UNUSED;
    case AssociationOutcome::rejected:
      return association_t::REJECTED;
    case AssociationOutcome::created:
      return association_t::CREATED;
  }
  return association_t::REJECTED;
}

landmark_t to_message(const Landmark& landmark) {
  MapLandmark m;
  m.id = landmark.id;
  m.mean = landmark.mean;
  m.covariance = landmark.covariance;
  m.observations = landmark.observations;
  m.rgb = landmark.colour;
  m.descriptor = landmark.descriptor;
  m.laplacian = landmark.laplacian;
  return to_message(m, landmark.log_odds);
}

}  // namespace

FastSlamNode::FastSlamNode(const ConfigNode& config, Publisher& publisher)
    : publisher_(publisher),
      settings_(read_fastslam_settings(config)),
      pose_(config.choice("pose", "auto", {"auto", "planar", "6dof"})),
      frame_queue_(frame_queue(config, 3)),
      join_(config.get("max_wait", 0.15, Range{0, 10}), std::max<std::size_t>(6, frame_queue_),
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
  // No odometry: the robot may have gone anywhere that its speed allows.
  const double seconds = 1e-6 * static_cast<double>(utime - last_utime_);
  Motion motion;
  motion.covariance.diagonal().head<3>().setConstant(std::pow(0.5 * seconds, 2));
  motion.covariance.diagonal().tail<3>().setConstant(std::pow(1.0 * seconds, 2));
  return motion;
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
  pose_estimate_t pose = make_pose_estimate(frame.utime, result.T_world_robot, result.covariance);
  pose.status = wire_status(result.status);
  pose.quality =
      result.offered > 0 ? static_cast<float>(result.used) / static_cast<float>(result.offered) : 0.F;
  pose.inliers = result.used;
  pose.map_revision = revision_;
  pose.processing_time = cpu_time;
  pose.detail = result.slipped ? "wheels slipped" : "";
  publisher_.publish("FASTSLAM_POSE", pose);
  publish_particles(frame.utime, result);
  publish_associations(frame, result);
  publish_changes(frame.utime);
}

void FastSlamNode::publish_particles(Utime utime, const StepResult& result) {
  particles_t m;
  m.utime = utime;
  m.frame = "map";
  m.effective_sample_size = static_cast<float>(result.effective_sample_size);
  m.best = result.best;
  const std::vector<double> weights = slam_->weights();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const rigid_transform_t T = lcmslam::to_message(slam_->particles()[i].T_world_robot);
    particle_t p;
    for (int k = 0; k < 3; ++k) p.trans[k] = static_cast<float>(T.trans[k]);
    for (int k = 0; k < 4; ++k) p.quat[k] = static_cast<float>(T.quat[k]);
    p.weight = static_cast<float>(weights[i]);
    m.particles.push_back(p);
  }
  m.total = m.n_particles = static_cast<int32_t>(m.particles.size());
  publisher_.publish("FASTSLAM_PARTICLES", m);
}

void FastSlamNode::publish_associations(const FeatureFrame& frame, const StepResult& result) {
  associations_t m{};
  m.utime = frame.utime;
  m.width = frame.width;
  m.height = frame.height;
  for (const AssociationReport& report : result.associations) {
    const Feature& feature = frame.features[static_cast<std::size_t>(report.feature)];
    association_t a;
    a.feature = report.feature;
    a.x = feature.x;
    a.y = feature.y;
    a.landmark = report.landmark;
    a.outcome = wire_outcome(report.outcome);
    m.associations.push_back(a);
  }
  m.n_associations = static_cast<int32_t>(m.associations.size());
  publisher_.publish("FASTSLAM_ASSOCIATIONS", m);
}

void FastSlamNode::publish_changes(Utime utime) {
  const MapChanges changes = slam_->take_changes();
  if (changes.changed.empty() && changes.removed.empty()) return;
  std::vector<landmark_t> landmarks;
  for (const Landmark& landmark : changes.changed) landmarks.push_back(to_message(landmark));
  // A change that needs several tiles goes out as several changes, each on top of the one before.
  for (landmarks_t& tile : make_landmark_tiles(utime, 0, 0, landmarks, changes.removed)) {
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
  std::vector<landmark_t> landmarks;
  for (const Landmark& landmark : slam_->landmarks()) landmarks.push_back(to_message(landmark));
  for (const landmarks_t& tile : make_landmark_tiles(last_utime_, revision_, 0, landmarks, {})) {
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
