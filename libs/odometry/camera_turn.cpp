#include <lcmslam/odometry/camera_turn.hpp>

#include <Eigen/Cholesky>
#include <cmath>

#include <lcmslam/features/rigid_ransac.hpp>

namespace lcmslam {
namespace {

constexpr int iterations = 8;
constexpr double kernel = 1;  // pixels, of Cauchy's weight

struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
};

/// A point of one frame, `p` in the other's camera, and the pixel there; `dp` is p's derivative by the step.
void add_pixel(const Eigen::Vector3d& p, const Eigen::Matrix<double, 3, 6>& dp, const Feature& at,
               const FeatureFrame& frame, NormalEquations& sum) {
  if (!(p.z() > 0.1)) return;
  const double x = p.x() / p.z(), y = p.y() / p.z();
  const Eigen::Vector2d error(frame.fx * x + frame.cx - static_cast<double>(at.x),
                              frame.fy * y + frame.cy - static_cast<double>(at.y));
  Eigen::Matrix<double, 2, 3> projection;
  projection << frame.fx / p.z(), 0, -frame.fx * x / p.z(), 0, frame.fy / p.z(), -frame.fy * y / p.z();
  const Eigen::Matrix<double, 2, 6> J = projection * dp;
  const double weight = 1 / (1 + error.squaredNorm() / (kernel * kernel));
  sum.H += weight * J.transpose() * J;
  sum.g += weight * J.transpose() * error;
}

}  // namespace

// T exp(xi): a point of b moves in a by R (v + w x p); a point of a in b, T^-1 p, by -(v + w x p).
Eigen::Isometry3d refine_by_pixels(const FeatureFrame& a, const FeatureFrame& b,
                                   const std::vector<Match>& matches, Eigen::Isometry3d T_a_b) {
  for (int i = 0; i < iterations; ++i) {
    NormalEquations sum;
    Eigen::Matrix<double, 3, 6> body;
    body.leftCols<3>().setIdentity();
    for (const Match& match : matches) {
      const Feature &f = a.features[static_cast<std::size_t>(match.a)],
                    &g = b.features[static_cast<std::size_t>(match.b)];
      if (g.point.allFinite()) {
        const Eigen::Vector3d p = g.point.cast<double>();
        body.rightCols<3>() = -hat(p);
        add_pixel(T_a_b * p, T_a_b.linear() * body, f, a, sum);
      }
      if (f.point.allFinite()) {
        const Eigen::Vector3d p = T_a_b.inverse() * f.point.cast<double>();
        body.rightCols<3>() = -hat(p);
        add_pixel(p, -body, g, b, sum);
      }
    }
    const Vector6d step = -sum.H.ldlt().solve(sum.g);
    if (!step.allFinite() || step.norm() > 1) break;
    T_a_b = T_a_b * se3_exp(step);
    if (step.norm() < 1e-7) break;
  }
  return T_a_b;
}

std::optional<CameraTurn::Step> CameraTurn::add(const FeatureFrame& frame) {
  std::optional<Step> result;
  if (last_ && frame.utime > last_->utime) {
    const std::vector<Match> matches = matcher_.match(last_->features, frame.features);
    const RigidRansacResult found = align_ransac(*last_, frame, matches, {}, random_);
    if (found.success) {
      std::vector<Match> agreeing;
      for (const int i : found.inliers) agreeing.push_back(matches[static_cast<std::size_t>(i)]);
      const Eigen::Isometry3d T = refine_by_pixels(*last_, frame, agreeing, found.T_a_b);
      result = Step{last_->utime, frame.utime, so3_log(T.linear())};
    }
  }
  last_ = frame;
  return result;
}

}  // namespace lcmslam
