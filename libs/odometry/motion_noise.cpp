#include <lcmslam/odometry/motion_noise.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lcmslam {

void MotionNoiseSettings::check() const {
  for (const double s : {sigma.x(), sigma.y(), sigma.z()}) {
    if (!(std::isfinite(s) && s >= 0)) {
      throw std::invalid_argument("motion noise: sigma is " + std::to_string(s) +
                                  "; expected metres, at least 0");
    }
  }
  if (!(std::isfinite(rate) && rate > 0 && rate <= 1e5)) {
    throw std::invalid_argument("motion noise: rate is " + std::to_string(rate) +
                                "; expected Hz in (0, 1e5]");
  }
}

MotionNoise::MotionNoise(const MotionNoiseSettings& settings, Random random)
    : settings_(settings), random_(random) {
  settings_.check();
}

void MotionNoise::draw(int count) {
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d step;
    for (int axis = 0; axis < 3; ++axis) step[axis] = random_.normal(0, settings_.sigma[axis]);
    const bool walk = settings_.mode == MotionNoiseMode::random_walk;
    offset_ = walk ? Eigen::Vector3d(offset_ + step) : step;
    variance_ += (walk ? 1.0 : 2.0) * settings_.sigma.cwiseAbs2();
  }
}

MotionSample MotionNoise::apply(const MotionSample& sample) {
  if (!start_ || sample.utime < newest_) {
    start_ = sample.utime;
    before_.reset();
    draws_ = 0;
    offset_.setZero();
    variance_.setZero();
    if (settings_.mode == MotionNoiseMode::white) draw(1);
  }
  newest_ = sample.utime;

  // A gap of hours must not cost hours: beyond a thousand, the walk's shape between is not needed.
  const double elapsed = 1e-6 * static_cast<double>(sample.utime - *start_);
  const auto due = static_cast<std::int64_t>(std::floor(elapsed * settings_.rate + 1e-9));
  draw(static_cast<int>(std::min<std::int64_t>(due - draws_, 1000)));
  draws_ = due;

  MotionSample noisy = sample;
  noisy.T_odom_robot.translation() += offset_;
  if (before_) {
    const auto moved = [&](const MotionSample& from, const MotionSample& to) {
      const Matrix6d A = adjoint(to.T_odom_robot.inverse() * from.T_odom_robot);
      return Matrix6d(A * from.covariance * A.transpose());
    };
    noisy.covariance += moved(before_->noisy, noisy) - moved(before_->clean, sample);
  }
  const Eigen::Matrix3d R = sample.T_odom_robot.linear();
  noisy.covariance.topLeftCorner<3, 3>() += R.transpose() * variance_.asDiagonal() * R;
  variance_.setZero();
  before_ = {sample, noisy};
  return noisy;
}

}  // namespace lcmslam
