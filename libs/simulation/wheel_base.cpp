#include <lcmslam/simulation/wheel_base.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

/// Motion in the robot's own plane during one step, in its frame: m, m, rad.
using Step = Eigen::Vector3d;

/// Of the constant twist, times the step's duration, that leads from a to b what wheels measure.
Step step_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Vector6d twist = se3_log(a.inverse() * b);
  return {twist[0], twist[1], twist[5]};
}

/// Turns true motion into the motion that the wheels seem to have made.
class Corruption {
 public:
  Corruption(const WheelErrors& errors, std::uint64_t seed) : errors_(errors), random_(seed, 0x3eef) {
    scale_ = {about(errors.translation_scale), about(errors.lateral_scale), about(errors.rotation_scale)};
    to_next_slip_ = next_gap();
  }

  Step operator()(const Step& truth) {
    const double distance = truth.head<2>().norm();
    Step measured = truth.cwiseProduct(scale_);
    if (distance > 0) {
      const double root = std::sqrt(distance);
      const Step drift(errors_.position_drift, errors_.position_drift, errors_.heading_drift);
      const Step noise(random_.normal(), random_.normal(), random_.normal());
      measured += root * drift.cwiseProduct(noise);
    }
    return measured + slip(truth, distance);
  }

 private:
  double sign() { return random_.uniform() < 0.5 ? -1 : 1; }
  double about(double magnitude) {
    const double relative = 1 + errors_.spread * random_.uniform(-1, 1);
    return 1 + sign() * magnitude * relative;
  }
  double next_gap() { return errors_.slip_every * random_.uniform(0.6, 1.4); }

  /// A slip lasts 0.2 s: wheels that spin measure too much, wheels that skid too little.
  Step slip(const Step& truth, double distance) {
    if (errors_.slip_every <= 0) return Step::Zero();
    to_next_slip_ -= distance;
    if (to_next_slip_ <= 0 && slip_steps_ == 0) {
      to_next_slip_ += next_gap();
      slip_steps_ = slip_duration;
      const double length = sign() * random_.uniform(errors_.slip_low, errors_.slip_high);
      const double angle = sign() * random_.uniform(errors_.slip_angle_low, errors_.slip_angle_high);
      const Eigen::Vector2d along = truth.head<2>() / distance;
      slip_ = Step(length * along.x(), length * along.y(), angle) / slip_duration;
    }
    if (slip_steps_ == 0) return Step::Zero();
    --slip_steps_;
    return slip_;
  }

  static constexpr int slip_duration = 10;  // steps
  const WheelErrors errors_;
  Random random_;
  Step scale_;
  double to_next_slip_ = 0;
  int slip_steps_ = 0;
  Step slip_ = Step::Zero();
};

/// Turns a wheel by the motion of its contact point; returns its travel along the rolling direction.
using WheelModel = double (*)(const Eigen::Vector2d& contact, Wheel& wheel);

double roll(const Eigen::Vector2d& contact, Wheel& wheel) {
  const double c = std::cos(wheel.steering), s = std::sin(wheel.steering);
  const double along = c * contact.x() + s * contact.y(), across = c * contact.y() - s * contact.x();
  return along + across * std::tan(wheel.roller_angle);
}

/// The wheel turns into the direction of its contact's motion, forwards or backwards, whichever is
/// nearer; at standstill it stays as it is.
double steer_and_roll(const Eigen::Vector2d& contact, Wheel& wheel) {
  if (contact.norm() > 2e-5) {
    const double direction = std::atan2(contact.y(), contact.x());
    wheel.steering += std::remainder(direction - wheel.steering, M_PI);
  }
  return roll(contact, wheel);
}

}  // namespace

WheelErrors WheelErrors::none() {
  WheelErrors errors;
  errors.translation_scale = errors.lateral_scale = errors.rotation_scale = 0;
  errors.heading_drift = errors.position_drift = errors.slip_every = 0;
  return errors;
}

bool is_holonomic(const std::string& base) {
  return base != "differential";
}

std::vector<Wheel> make_wheels(const std::string& base) {
  const auto wheel = [](double x, double y, double radius, double roller_angle) {
    Wheel result;
    result.x = x, result.y = y, result.radius = radius, result.roller_angle = roller_angle;
    return result;
  };
  if (base == "differential") return {wheel(0, 0.22, 0.1, 0), wheel(0, -0.22, 0.1, 0)};
  if (base == "steered")
    return {wheel(0.23, 0.18, 0.07, 0), wheel(0.23, -0.18, 0.07, 0), wheel(-0.23, 0.18, 0.07, 0),
            wheel(-0.23, -0.18, 0.07, 0)};
  const double a = M_PI / 4;
  if (base == "mecanum")
    return {wheel(0.2, 0.2, 0.076, -a), wheel(0.2, -0.2, 0.076, a), wheel(-0.2, 0.2, 0.076, a),
            wheel(-0.2, -0.2, 0.076, -a)};
  throw std::invalid_argument("base '" + base + "' is not known: use differential, steered or mecanum");
}

std::vector<CarryingWheel> carrying_wheels(const std::string& base) {
  std::vector<CarryingWheel> wheels;
  for (const Wheel& wheel : make_wheels(base)) wheels.push_back({wheel.x, wheel.y, wheel.radius});
  if (base == "differential")
    for (const double x : {0.23, -0.23}) wheels.push_back({x, 0, 0.05});
  return wheels;
}

std::vector<Encoders> simulate_encoders(const DrivenPath& path, const std::string& base, Utime start,
                                        std::uint64_t seed, const WheelErrors& errors) {
  const WheelModel move = base == "steered" ? steer_and_roll : roll;
  Corruption corrupt(errors, seed);
  std::vector<Wheel> wheels = make_wheels(base);
  std::vector<double> travel(wheels.size(), 0.0);  // m, before quantisation
  std::vector<Encoders> readings{{start, 0, 0, wheels}};
  const double period = static_cast<double>(encoder_period) * 1e-6;
  const auto steps = static_cast<int>(std::ceil(path.duration() / period));
  for (int k = 1; k <= steps; ++k) {
    const Step motion = corrupt(step_between(path.pose((k - 1) * period), path.pose(k * period)));
    for (std::size_t i = 0; i < wheels.size(); ++i) {
      Wheel& wheel = wheels[i];
      const Eigen::Vector2d contact(motion.x() - motion.z() * wheel.y, motion.y() + motion.z() * wheel.x);
      travel[i] += move(contact, wheel);
      wheel.angle = std::round(travel[i] / errors.quantum) * errors.quantum / wheel.radius;
    }
    readings.push_back({start + k * encoder_period, k, 0, wheels});
  }
  return readings;
}

}  // namespace lcmslam
