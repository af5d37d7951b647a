#include <lcmslam/odometry/odometry_clock.hpp>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr Utime longest_gap = 500'000;  // us, between odometry's samples
constexpr std::size_t fewest_steps = 10;
constexpr double tolerance = 1e-5;  // s
constexpr int phases = 8;

Utime microseconds_of(double s) {
  return std::llround(1e6 * s);
}

}  // namespace

/// Of both sets of turns at one offset.
struct OdometryClock::Likeness {
  double rest = 0;  // rad^2, squared differences in all
  double scale = 1, correlation = 0;
  std::vector<double> differences;  // rad, of each step
};

OdometryClock::OdometryClock(const OdometryClockSettings& settings) : settings_(settings) {
  check(settings_, "odometry clock");
}

void OdometryClock::add_camera(Utime utime, const Eigen::Isometry3d& T_world_camera) {
  if (last_utime_ != 0)
    add_camera_step(last_utime_, utime,
                    so3_log(T_world_last_.linear().transpose() * T_world_camera.linear()));
  last_utime_ = utime;
  T_world_last_ = T_world_camera;
}

void OdometryClock::add_camera_step(Utime from, Utime to, const Eigen::Vector3d& turn) {
  if (to < from || (!steps_.empty() && from < steps_.back().from)) steps_.clear();
  const double since = 1e-6 * static_cast<double>(to - from);
  if (since > 0 && since <= settings_.longest_step) steps_.push_back({from, to, turn});
}

void OdometryClock::add_odometry(const MotionSample& sample) {
  if (!odometry_.empty() && sample.utime < odometry_.back().first) odometry_.clear();
  if (!odometry_.empty() && sample.utime == odometry_.back().first) return;
  odometry_.emplace_back(sample.utime, sample.T_odom_robot.linear());
}

/// Without a gap.
bool OdometryClock::is_covered(Utime from, Utime to) const {
  const auto is_before = [](const auto& sample, Utime t) { return sample.first < t; };
  if (odometry_.empty() || from < odometry_.front().first || to > odometry_.back().first) return false;
  Utime last = from;
  for (auto s = std::lower_bound(odometry_.begin(), odometry_.end(), from, is_before); last < to; ++s) {
    const Utime begin = s == odometry_.begin() ? s->first : std::prev(s)->first;
    if (s->first - begin > longest_gap) return false;
    last = s->first;
  }
  return true;
}

/// Of odometry, in the mean.
Utime OdometryClock::period() const {
  return (odometry_.back().first - odometry_.front().first) /
         static_cast<Utime>(std::max<std::size_t>(1, odometry_.size() - 1));
}

std::optional<Eigen::Quaterniond> OdometryClock::odometry_at(Utime utime) const {
  const auto after = std::lower_bound(odometry_.begin(), odometry_.end(), utime,
                                      [](const auto& sample, Utime t) { return sample.first < t; });
  if (after == odometry_.end() || (after == odometry_.begin() && after->first != utime)) return std::nullopt;
  if (after->first == utime) return after->second;
  const auto before = std::prev(after);
  if (after->first - before->first > longest_gap) return std::nullopt;
  return before->second.slerp(
      static_cast<double>(utime - before->first) / static_cast<double>(after->first - before->first),
      after->second);
}

std::optional<Eigen::Vector3d> OdometryClock::odometry_turn(Utime from, Utime to) const {
  const auto a = odometry_at(from), b = odometry_at(to);
  if (!a || !b) return std::nullopt;
  const Eigen::AngleAxisd turn(a->conjugate() * *b);
  return turn.angle() * turn.axis();
}

// Between two samples odometry's noise averages: stamps that fall there would look better than they are. The
// mean over two periods looks the same wherever stamps fall.
std::optional<Eigen::Vector3d> OdometryClock::odometry_turn_around(Utime from, Utime to) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < phases; ++i) {
    const Utime shift = (2 * i + 1 - phases) * period() / phases;
    const auto turn = odometry_turn(from + shift, to + shift);
    if (!turn) return std::nullopt;
    sum += *turn;
  }
  return sum / phases;
}

// The rotation between both frames and the scale that leave the least (Kabsch 1976; Umeyama 1991).
std::optional<OdometryClock::Likeness> OdometryClock::compare(double offset,
                                                              const std::vector<CameraStep>& steps) const {
  std::vector<Eigen::Vector3d> turns;
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  double camera2 = 0, odometry2 = 0;
  const Utime shift = microseconds_of(offset);
  for (const CameraStep& step : steps) {
    const auto turn = odometry_turn_around(step.from - shift, step.to - shift);
    if (!turn) return std::nullopt;
    turns.push_back(*turn);
    C += step.turn * turns.back().transpose();
    camera2 += step.turn.squaredNorm();
    odometry2 += turns.back().squaredNorm();
  }
  if (!(camera2 > 0 && odometry2 > 0)) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Vector3d signs(1, 1, sign);
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const double together = svd.singularValues().dot(signs);
  Likeness result;
  result.scale = together / odometry2;
  result.rest = camera2 - together * together / odometry2;
  result.correlation = together / std::sqrt(camera2 * odometry2);
  for (std::size_t i = 0; i < steps.size(); ++i)
    result.differences.push_back((steps[i].turn - result.scale * R * turns[i]).norm());
  return result;
}

OdometryClock::Offset OdometryClock::estimate() const {
  Offset result;
  // Steps that odometry covers at every offset.
  std::vector<CameraStep> steps;
  const Utime reach = microseconds_of(settings_.range) + (odometry_.empty() ? 0 : period());
  double turned = 0;
  for (const CameraStep& step : steps_)
    if (is_covered(step.from - reach, step.to + reach)) {
      steps.push_back(step);
      turned += step.turn.norm();
    }
  const auto refuse = [&](const std::string& reason) {
    result.reason = reason;
    return result;
  };
  if (steps.size() < fewest_steps)
    return refuse("only " + std::to_string(steps.size()) +
                  " steps between images lie where odometry is known for " + "the whole range of offsets; " +
                  std::to_string(fewest_steps) + " are needed");
  if (turned < settings_.least_turn) return refuse("the robot has hardly turned: drive some bends");

  const auto rest = [&](double offset) {
    const auto likeness = compare(offset, steps);
    return likeness ? likeness->rest : 1e300;
  };
  const int half = static_cast<int>(std::ceil(settings_.range / settings_.step - 1e-9));
  const auto coarse = [&] {
    double best = 0, least = 1e300;
    for (int i = -half; i <= half; ++i) {
      const double offset = settings_.range * i / half, r = rest(offset);
      if (r < least) best = offset, least = r;
    }
    return best;
  };
  const auto refined = [&](double best) {
    constexpr double golden = 0.618033988749895;
    double low = best - settings_.step, high = best + settings_.step;
    low = std::max(low, -settings_.range), high = std::min(high, settings_.range);
    while (high - low > tolerance) {
      const double a = high - golden * (high - low), b = low + golden * (high - low);
      if (rest(a) < rest(b))
        high = b;
      else
        low = a;
    }
    return 0.5 * (low + high);
  };
  // A wrong step of visual odometry must not decide: once more without those that differ much.
  double best = refined(coarse());
  if (const auto likeness = compare(best, steps)) {
    std::vector<double> sorted = likeness->differences;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                     sorted.end());
    const double limit = settings_.outlier * sorted[sorted.size() / 2] + 1e-9;
    std::vector<CameraStep> agreeing;
    for (std::size_t i = 0; i < steps.size(); ++i)
      if (likeness->differences[i] <= limit) agreeing.push_back(steps[i]);
    if (agreeing.size() >= fewest_steps) steps = std::move(agreeing);
  }
  best = refined(coarse());
  if (std::abs(best) > settings_.range - 1.5 * settings_.step)
    return refuse("the clocks differ by more than is looked for, or the turns are not alike at any offset");

  const auto likeness = compare(best, steps);
  if (!likeness) return refuse("the turns are not alike at any offset");
  const double h = 0.5 * settings_.step;
  const double curvature = (rest(best + h) - 2 * rest(best) + rest(best - h)) / (h * h);
  result.offset = best;
  result.scale = likeness->scale;
  result.likeness = likeness->correlation;
  result.steps = static_cast<int>(steps.size());
  // Wheels err about one axis: as if all that is left was there.
  const double variance = likeness->rest / static_cast<double>(steps.size());
  result.sigma =
      curvature > 0 ? settings_.correlation * std::sqrt(2 * variance / curvature) : settings_.range;
  if (result.sigma > settings_.largest_sigma) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the turns leave the offset open by %.0f ms: drive quicker bends, both ways",
                  1e3 * result.sigma);
    return refuse(text);
  }
  result.known = true;
  return result;
}

}  // namespace lcmslam
