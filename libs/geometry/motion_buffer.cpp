#include <lcmslam/geometry/motion_buffer.hpp>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr Utime shortest_step = 5'000;  // us that tell a speed

// What another driver sends may not add up along its path, and rounding makes the difference of equals
// negative: the nearest positive semidefinite matrix then (Higham 1988), which is the same one otherwise.
Matrix6d nearest_covariance(const Matrix6d& Q) {
  const Matrix6d symmetric = 0.5 * (Q + Q.transpose());
  if (!symmetric.allFinite() || symmetric.isZero(0)) return symmetric;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(symmetric);
  if (eigen.eigenvalues().minCoeff() >= 0) return symmetric;
  const Matrix6d& V = eigen.eigenvectors();
  const Matrix6d P = V * eigen.eigenvalues().cwiseMax(0).asDiagonal() * V.transpose();
  return 0.5 * (P + P.transpose());
}

Matrix6d increment_covariance(const MotionSample& a, const MotionSample& b) {
  const Matrix6d A = adjoint(b.T_odom_robot.inverse() * a.T_odom_robot);
  return nearest_covariance(b.covariance - A * a.covariance * A.transpose());
}

}  // namespace

Motion unknown_motion(Utime elapsed) {
  constexpr double speed = 0.5, turn_rate = 1, any_turn = 3;  // m/s, rad/s, rad: every heading is as likely
  const double seconds = 1e-6 * static_cast<double>(elapsed);
  Motion motion;
  motion.covariance.diagonal().head<3>().setConstant(std::pow(speed * seconds, 2));
  motion.covariance.diagonal().tail<3>().setConstant(std::pow(std::min(turn_rate * seconds, any_turn), 2));
  return motion;
}

bool MotionBuffer::add(const MotionSample& sample) {
  if (!samples_.empty() && sample.utime == samples_.back().utime) return true;
  const bool in_order = samples_.empty() || sample.utime > samples_.back().utime;
  if (!in_order) samples_.clear();
  samples_.push_back(sample);
  while (samples_.back().utime - samples_.front().utime > span_us_) samples_.pop_front();
  return in_order;
}

bool MotionBuffer::covers(Utime utime) const {
  return !samples_.empty() && samples_.front().utime <= utime && utime <= samples_.back().utime;
}

std::optional<MotionSample> MotionBuffer::at(Utime utime, Utime extrapolation) const {
  const bool beyond = samples_.size() > 1 && utime > newest() && utime <= newest() + extrapolation;
  if (!beyond && !covers(utime)) return std::nullopt;
  auto after = std::lower_bound(samples_.begin(), samples_.end(), utime,
                                [](const MotionSample& s, Utime t) { return s.utime < t; });
  if (beyond) after = std::prev(samples_.end());
  if (after->utime == utime) return *after;
  auto before = std::prev(after);
  if (beyond)  // samples that came together tell no speed
    while (before != samples_.begin() && after->utime - before->utime < shortest_step) --before;
  const MotionSample& a = *before;
  const MotionSample& b = *after;
  const double fraction = static_cast<double>(utime - a.utime) / static_cast<double>(b.utime - a.utime);

  MotionSample s;
  s.utime = utime;
  s.visual = b.visual;
  s.T_odom_robot = interpolate(a.T_odom_robot, b.T_odom_robot, fraction);
  const Matrix6d A = adjoint(s.T_odom_robot.inverse() * a.T_odom_robot);
  s.covariance = A * a.covariance * A.transpose() + fraction * increment_covariance(a, b);
  return s;
}

std::optional<Motion> MotionBuffer::between(Utime from, Utime to, Utime extrapolation) const {
  if (to < from) {
    auto motion = between(to, from, extrapolation);
    if (motion) motion->T_from_to = motion->T_from_to.inverse();
    return motion;
  }
  const auto a = at(from, extrapolation);
  const auto b = at(to, extrapolation);
  if (!a || !b || has_gap(from, to)) return std::nullopt;
  return Motion{a->T_odom_robot.inverse() * b->T_odom_robot, increment_covariance(*a, *b),
                a->visual || b->visual};
}

bool MotionBuffer::has_gap(Utime from, Utime to) const {
  const auto first = std::lower_bound(samples_.begin(), samples_.end(), from,
                                      [](const MotionSample& s, Utime t) { return s.utime < t; });
  Utime last = from;
  for (auto sample = first; sample != samples_.end() && last < to; ++sample) {
    const Utime before = sample == samples_.begin() ? sample->utime : std::prev(sample)->utime;
    if (sample->utime - before > longest_step && sample->utime > from) return true;
    last = sample->utime;
  }
  return false;
}

}  // namespace lcmslam
