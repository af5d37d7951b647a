// The transform between the estimate's and the truth's world (trajectory_error.hpp).

#include <Eigen/SVD>
#include <cmath>

#include <lcmslam/evaluation/trajectory_error.hpp>

namespace lcmslam {
namespace {

struct Moments {
  Eigen::Vector3d truth_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // mean of truth * estimate^T, centred
  double estimate_variance = 0;
};

Moments moments(const std::vector<MatchedPose>& matches) {
  Moments m;
  const auto n = static_cast<double>(matches.size());
  for (const MatchedPose& match : matches) {
    m.truth_mean += match.T_world_truth.translation() / n;
    m.estimate_mean += match.T_world_estimate.translation() / n;
  }
  for (const MatchedPose& match : matches) {
    const Eigen::Vector3d truth = match.T_world_truth.translation() - m.truth_mean;
    const Eigen::Vector3d estimate = match.T_world_estimate.translation() - m.estimate_mean;
    m.cross += truth * estimate.transpose() / n;
    m.estimate_variance += estimate.squaredNorm() / n;
  }
  return m;
}

WorldAlignment from_rotation(const Moments& m, const Eigen::Matrix3d& rotation, double scale) {
  WorldAlignment alignment;
  alignment.scale = scale;
  alignment.T_truth_estimate.linear() = rotation;
  alignment.T_truth_estimate.translation() = m.truth_mean - scale * rotation * m.estimate_mean;
  return alignment;
}

// Umeyama 1991, equations 40 to 42. Straight paths leave the rotation about the line free: any choice
// has the same, least, error, so that they need no special case.
WorldAlignment umeyama(const Moments& m, bool with_scale) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  if (!with_scale) return from_rotation(m, rotation, 1);
  if (m.estimate_variance < 1e-18) {
    throw std::invalid_argument("sim3 alignment: the estimate does not move, so that it has no scale");
  }
  return from_rotation(m, rotation, svd.singularValues().dot(sign) / m.estimate_variance);
}

// Best heading in the plane; heights stay as they are.
WorldAlignment planar(const Moments& m) {
  const double heading = std::atan2(m.cross(1, 0) - m.cross(0, 1), m.cross(0, 0) + m.cross(1, 1));
  WorldAlignment alignment =
      from_rotation(m, Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1);
  alignment.T_truth_estimate.translation().z() = 0;
  return alignment;
}

}  // namespace

WorldAlignment find_alignment(const std::vector<MatchedPose>& matches, Alignment alignment) {
  if (matches.empty()) throw std::invalid_argument("alignment of trajectories without a matched pose");
  switch (alignment) {
    case Alignment::none:
      return {};
    case Alignment::first_pose:
      return {1, matches.front().T_world_truth * matches.front().T_world_estimate.inverse()};
    case Alignment::se2:
      return planar(moments(matches));
    case Alignment::se3:
      return umeyama(moments(matches), false);
    case Alignment::sim3:
      return umeyama(moments(matches), true);
  }
  throw std::invalid_argument("unknown alignment");
}

Eigen::Isometry3d apply(const WorldAlignment& alignment, const Eigen::Isometry3d& T_world_estimate) {
  Eigen::Isometry3d scaled = T_world_estimate;
  scaled.translation() *= alignment.scale;
  return alignment.T_truth_estimate * scaled;
}

std::vector<MatchedPose> align(std::vector<MatchedPose> matches, const WorldAlignment& alignment) {
  for (MatchedPose& match : matches) match.T_world_estimate = apply(alignment, match.T_world_estimate);
  return matches;
}

}  // namespace lcmslam
