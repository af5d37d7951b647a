#include "procs/odometry/odometry_node.hpp"

#include <spdlog/spdlog.h>
#include <cmath>
#include <utility>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {
namespace {

std::optional<MotionNoise> make_noise(const PathNoiseSettings& settings) {
  if (settings.mode == "none") return std::nullopt;
  MotionNoiseSettings noise;
  noise.mode = settings.mode == "white" ? MotionNoiseMode::white : MotionNoiseMode::random_walk;
  noise.sigma = Eigen::Vector3d(settings.sigma, settings.sigma, 0);
  noise.rate = settings.rate;
  return MotionNoise(noise, Random(settings.seed));
}

}  // namespace

OdometryNodeSettings OdometryNode::read(const ConfigNode& config) {
  return read_settings<OdometryNodeSettings>(config);
}

OdometryNode::OdometryNode(const ConfigNode& config, Publisher& publisher)
    : OdometryNode(read(config), publisher) {}

OdometryNode::OdometryNode(const OdometryNodeSettings& settings, Publisher& publisher)
    : publisher_(publisher),
      choice_(settings.auto_wait),
      named_(settings.source != "auto"),
      external_channel_(settings.external_channel),
      clock_offset_(std::llround(1e6 * settings.clock_offset)),
      frame_queue_(static_cast<std::size_t>(settings.frame_queue)),
      wheels_(settings.wheels),
      twist_(settings.twist),
      visual_(settings.visual, Random(settings.seed)),
      noise_(make_noise(settings.noise)) {
  for (const auto& [name, source] : odometry_sources)
    if (settings.source == name) choice_ = SourceChoice(source);
}

void OdometryNode::connect(Inputs& inputs) {
  listen<encoders_t>(inputs, OdometrySource::wheels, 500,
                     [this](const encoders_t& m) { on_encoders(from_message(m)); });
  listen<twist_t>(inputs, OdometrySource::twist, 500,
                  [this](const twist_t& m) { on_twist(from_message(m)); });
  listen<pose_t>(inputs, OdometrySource::external, 500, [this](const pose_t& m) { on_pose(m); });
  listen<features_t>(inputs, OdometrySource::visual, frame_queue_,
                     [this](const features_t& m) { on_features(from_message(m)); });
}

template <class M>
void OdometryNode::listen(Inputs& inputs, OdometrySource source, std::size_t capacity,
                          std::function<void(const M&)> handler) {
  const bool takes_it = named_ && choice_.chosen() == source;
  const bool is_clock = source == OdometrySource::visual && choice_.chosen() == OdometrySource::twist;
  if (named_ && !takes_it && !is_clock) return;
  Input& input =
      inputs.subscribe_measured<M>(odometry_channel(source, external_channel_), capacity, std::move(handler));
  input.primary = takes_it;
  if (takes_it) return;
  // What is not taken is not measured either: its clock may be another one.
  input.admits = [this, &input, source, judge = input.admits](std::int64_t sender, Utime utime) {
    input.primary = takes(source, utime);
    if (source == OdometrySource::visual) hold_twist(utime);
    return input.primary && judge(sender, utime);
  };
}

bool OdometryNode::takes(OdometrySource source, Utime utime) {
  if (!choice_.chosen()) {
    choice_.heard(source, utime);
    if (choice_.chosen()) spdlog::info("{}", report().detail);
  } else if (source < *choice_.chosen() && came_later_.empty()) {
    came_later_ = odometry_channel(source, external_channel_);
    spdlog::warn("{}", report().detail);
  }
  return choice_.chosen() == source;
}

void OdometryNode::on_pose(const pose_t& message) {
  const MotionSample sample = external_.update(message.utime + clock_offset_, from_message(message));
  publish(sample, to_message(sample, source()));
}

void OdometryNode::on_twist(Twist twist) {
  twist.utime += clock_offset_;
  if (const auto sample = twist_.update(twist)) publish_twist(*sample);
}

// Mappers would go on with the velocity before the last twist: that one stops the base, and no other comes.
// A wrong stamp, or another clock's, tells nothing of the time: two must agree.
void OdometryNode::hold_twist(Utime now) {
  const Utime step = now - std::exchange(clock_, now);
  if (choice_.chosen() != OdometrySource::twist || step <= 0 || step > MotionBuffer::longest_step) return;
  if (const auto sample = twist_.hold(now, now + step)) publish_twist(*sample);
}

void OdometryNode::publish_twist(const MotionSample& sample) {
  odometry_t message = to_message(sample, source());
  const auto twist = twist_.holding(sample.utime);
  for (int i = 0; twist && i < 3; ++i) {
    message.linear_velocity[i] = twist->linear(i);
    message.angular_velocity[i] = twist->angular(i);
  }
  publish(sample, message);
}

void OdometryNode::on_encoders(Encoders encoders) {
  encoders.utime += clock_offset_;
  std::optional<MotionSample> sample;
  try {
    sample = wheels_.update(encoders);
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
  if (!sample) return;
  odometry_t message = to_message(*sample, source());
  message.linear_velocity[2] = message.angular_velocity[0] = message.angular_velocity[1] = 0;
  message.linear_velocity[0] = wheels_.twist().vx;
  message.linear_velocity[1] = wheels_.twist().vy;
  message.angular_velocity[2] = wheels_.twist().w;
  publish(*sample, message);
}

void OdometryNode::on_features(const FeatureFrame& frame) {
  const auto sample = visual_.update(frame);
  if (!sample) return;
  odometry_t message = to_message(*sample, source());
  const VisualReport& report = visual_.report();
  if (report.status != VisualStatus::tracking) ++degraded_;
  message.status = report.status == VisualStatus::tracking   ? pose_estimate_t::TRACKING
                   : report.status == VisualStatus::degraded ? pose_estimate_t::DEGRADED
                                                             : pose_estimate_t::LOST;
  message.quality =
      report.matches > 0 ? static_cast<float>(report.inliers) / static_cast<float>(report.matches) : 0.F;
  publish(*sample, message);
}

void OdometryNode::publish(const MotionSample& sample, odometry_t message) {
  if (noise_) {
    const MotionSample noisy = noise_->apply(sample);
    message.T_odom_robot = to_message(noisy.T_odom_robot);
    to_message(noisy.covariance, message.covariance);
  }
  publisher_.publish("ODOMETRY", message);
  ++updates_;
}

NodeReport OdometryNode::report() const {
  NodeReport report;
  if (!choice_.chosen())
    report.detail = "waits for ENCODERS, TWIST, " + external_channel_ + " or FEATURES";
  else
    report.detail = std::string("source ") + source() + (named_ ? "" : ", by what came first") +
                    (noise_ ? ", noise added" : "");
  if (!came_later_.empty())
    report.detail +=
        "; " + came_later_ + " came later: odometry.source names it, or a longer odometry.auto_wait takes it";
  report.values = {{"updates", static_cast<double>(updates_)},
                   {"degraded", static_cast<double>(degraded_)},
                   {"restarts", static_cast<double>(wheels_.restarts() + external_.restarts())}};
  return report;
}

}  // namespace lcmslam
