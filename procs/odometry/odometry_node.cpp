#include "procs/odometry/odometry_node.hpp"

#include <lcmslam/messages/feature_messages.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/pose_t.hpp>
#include <lcmslam/runtime/arrival.hpp>

namespace lcmslam {
namespace {

WheelNoise read_wheel_noise(const ConfigNode& c) {
  WheelNoise n;
  const Range ratio{0, 1};
  n.longitudinal_scale = c.get("longitudinal_scale", n.longitudinal_scale, ratio);
  n.lateral_scale = c.get("lateral_scale", n.lateral_scale, ratio);
  n.rotation_scale = c.get("rotation_scale", n.rotation_scale, ratio);
  n.translation_drift = c.get("translation_drift", n.translation_drift, ratio);
  n.rotation_drift = c.get("rotation_drift", n.rotation_drift, ratio);
  n.slip_distance = c.get("slip_distance", n.slip_distance, Range{1e-3, 1e9});
  n.slip_translation = c.get("slip_translation", n.slip_translation, ratio);
  n.slip_rotation = c.get("slip_rotation", n.slip_rotation, ratio);
  return n;
}

WheelOdometrySettings read_wheels(const ConfigNode& c) {
  WheelOdometrySettings s;
  s.noise = read_wheel_noise(c);
  return s;
}

TwistOdometrySettings read_twist(const ConfigNode& c) {
  TwistOdometrySettings s;
  s.noise = read_wheel_noise(c);
  s.curve_noise = c.get("curve_noise", s.curve_noise, Range{0, 1});
  s.delay = c.get("delay", s.delay, Range{-10, 10});
  s.timeout = c.get("timeout", s.timeout, Range{0, 3600});
  s.max_speed = c.get("max_speed", s.max_speed, Range{0, 100});
  return s;
}

VisualOdometrySettings read_visual(const ConfigNode& c) {
  VisualOdometrySettings s;
  s.keyframe_inlier_ratio = c.get("keyframe_inlier_ratio", s.keyframe_inlier_ratio, Range{0, 1});
  s.keyframe_translation = c.get("keyframe_translation", s.keyframe_translation, Range{0, 100});
  s.keyframe_rotation = c.get("keyframe_rotation", s.keyframe_rotation, Range{0, 3.2});
  s.max_speed = c.get("max_speed", s.max_speed, Range{0.01, 100});
  s.max_turn_rate = c.get("max_turn_rate", s.max_turn_rate, Range{0.01, 100});
  return s;
}

/// Thesis, figure 2.10: Gaussian noise on the path, to see how much of it the mappers take away.
std::optional<MotionNoise> read_noise(const ConfigNode& c) {
  MotionNoiseSettings s;
  const std::string mode = c.choice("mode", "none", {"none", "random_walk", "white"});
  const double sigma = c.get("sigma", 0.02, Range{0, 10});
  s.mode = mode == "white" ? MotionNoiseMode::white : MotionNoiseMode::random_walk;
  s.sigma = Eigen::Vector3d(sigma, sigma, 0);
  s.rate = c.get("rate", s.rate, Range{0.01, 1000});
  const auto seed = static_cast<std::uint64_t>(c.get("seed", 1, Range{0, 2147483647}));
  if (mode == "none") return std::nullopt;
  return MotionNoise(s, Random(seed));
}

/// bot_core's pose_t has no covariance: what another driver's odometry is assumed to be worth.
MotionSample external_sample(const pose_t& m, const MotionSample& last) {
  MotionSample sample;
  sample.utime = m.utime;
  rigid_transform_t T;
  std::copy(std::begin(m.pos), std::end(m.pos), T.trans);
  std::copy(std::begin(m.orientation), std::end(m.orientation), T.quat);
  sample.T_odom_robot = from_message(T, "pose");
  const Eigen::Isometry3d step = sample.T_odom_robot.inverse() * last.T_odom_robot;
  const double way = step.translation().norm() + 0.3 * rotation_angle(step);
  const Matrix6d A = adjoint(step);
  sample.covariance = A * last.covariance * A.transpose() + (1e-8 + 4e-4 * way) * Matrix6d::Identity();
  return sample;
}

}  // namespace

OdometryNode::OdometryNode(const ConfigNode& config, Publisher& publisher)
    : publisher_(publisher),
      source_(config.choice("source", "wheels", {"wheels", "twist", "visual", "external"})),
      external_channel_(config.get("external_channel", "POSE_BODY")),
      frame_queue_(frame_queue(config, 4)),
      wheels_(read_wheels(config.section("wheels"))),
      twist_(read_twist(config.section("twist"))),
      visual_(read_visual(config.section("visual")),
              Random(static_cast<std::uint64_t>(config.get("seed", 1, Range{0, 2147483647})))),
      noise_(read_noise(config.section("noise"))) {}

void OdometryNode::connect(Inputs& inputs) {
  if (source_ == "wheels") {
    inputs
        .subscribe<encoders_t>("ENCODERS", 500, [this](const encoders_t& m) { on_encoders(from_message(m)); })
        .primary = true;
  } else if (source_ == "twist") {
    inputs.subscribe<twist_t>("TWIST", 500, [this](const twist_t& m) { on_twist(from_message(m)); }).primary =
        true;
  } else if (source_ == "visual") {
    inputs
        .subscribe<features_t>("FEATURES", frame_queue_,
                               [this](const features_t& m) { on_features(from_message(m)); })
        .primary = true;
  } else {
    inputs
        .subscribe<pose_t>(external_channel_, 500,
                           [this](const pose_t& m) {
                             external_ = external_sample(m, external_);
                             publish(external_, to_message(external_, source_));
                           })
        .primary = true;
  }
}

bool OdometryNode::is_late(Utime utime) {
  if (came_late(utime, last_utime_)) return true;
  last_utime_ = utime;
  return false;
}

void OdometryNode::on_twist(const Twist& twist) {
  if (is_late(twist.utime)) return;
  const auto sample = twist_.update(twist);
  if (!sample) return;
  odometry_t message = to_message(*sample, source_);
  for (int i = 0; i < 3; ++i) {
    message.linear_velocity[i] = twist.linear(i);
    message.angular_velocity[i] = twist.angular(i);
  }
  publish(*sample, message);
}

void OdometryNode::on_encoders(const Encoders& encoders) {
  if (is_late(encoders.utime)) return;
  std::optional<MotionSample> sample;
  try {
    sample = wheels_.update(encoders);
  } catch (const std::invalid_argument& error) {
    throw DecodeError(error.what());
  }
  if (!sample) return;
  odometry_t message = to_message(*sample, source_);
  message.linear_velocity[2] = message.angular_velocity[0] = message.angular_velocity[1] = 0;
  message.linear_velocity[0] = wheels_.twist().vx;
  message.linear_velocity[1] = wheels_.twist().vy;
  message.angular_velocity[2] = wheels_.twist().w;
  publish(*sample, message);
}

void OdometryNode::on_features(const FeatureFrame& frame) {
  const auto sample = visual_.update(frame);
  if (!sample) return;
  odometry_t message = to_message(*sample, source_);
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
  report.detail = "source " + source_ + (noise_ ? ", noise added" : "");
  report.values = {{"updates", static_cast<double>(updates_)}, {"degraded", static_cast<double>(degraded_)}};
  return report;
}

}  // namespace lcmslam
