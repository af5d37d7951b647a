#include <lcmslam/evaluation/map_placement.hpp>

#include <Eigen/SVD>

namespace lcmslam {
namespace {

// m: each orientation counts as points that far to all sides of its pose. A path that is much wider is placed
// by its positions, as for the ATE.
constexpr double orientation_lever = 0.03;

}  // namespace

Eigen::Isometry3d placed_by_poses(const std::vector<MatchedPose>& matches) {
  Eigen::Vector3d truth_mean = Eigen::Vector3d::Zero(), estimate_mean = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(matches.size());
  for (const MatchedPose& match : matches) {
    truth_mean += match.T_world_truth.translation() / n;
    estimate_mean += match.T_world_estimate.translation() / n;
  }
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (const MatchedPose& match : matches) {
    const Eigen::Vector3d truth = match.T_world_truth.translation() - truth_mean;
    const Eigen::Vector3d estimate = match.T_world_estimate.translation() - estimate_mean;
    cross += truth * estimate.transpose() / n;
    cross += orientation_lever * orientation_lever * match.T_world_truth.linear() *
             match.T_world_estimate.linear().transpose() / n;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  T.translation() = truth_mean - T.linear() * estimate_mean;
  return T;
}

}  // namespace lcmslam
