#include <lcmslam/fastslam/smoothing/shared_error.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

// A covariance as another frame has it: `A` is the adjoint of the change.
Matrix6d carried(const Matrix6d& A, const Matrix6d& covariance) {
  const Matrix6d P = A * covariance * A.transpose();
  return 0.5 * (P + P.transpose());
}

}  // namespace

void SharedError::observe(const std::vector<LandmarkMatch>& accepted, int minimum_consensus,
                          const Eigen::Isometry3d& T_world_robot, const Matrix6d& spread) {
  if (accepted.empty()) return;
  Compact sum = Compact::Zero();
  double shares = 0;  // of the spread
  for (const LandmarkMatch& match : accepted) {
    Record& landmark = landmarks_[static_cast<std::size_t>(match.slot)];
    sum += landmark.made_at;
    shares += 1.0 / landmark.observations++;
  }
  const auto count = static_cast<double>(accepted.size());
  const Matrix6d mean = (sum.cast<double>() + shares * carried(adjoint(T_world_robot), spread)) / count;
  const double part = count / (count + minimum_consensus);  // a few do not fix the whole pose
  covariance_ += part * (mean - covariance_);
}

void SharedError::create(const std::vector<LandmarkMatch>& created) {
  for (const LandmarkMatch& match : created) {
    const auto slot = static_cast<std::size_t>(match.slot);
    if (slot >= landmarks_.size()) landmarks_.resize(slot + 1);
    landmarks_[slot] = {covariance_.cast<float>(), 1};
  }
}

Matrix6d SharedError::at(const Eigen::Isometry3d& T_world_robot) const {
  return carried(adjoint(T_world_robot.inverse()), covariance_);
}

}  // namespace lcmslam
