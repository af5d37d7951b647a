#include <lcmslam/evaluation/body_offset.hpp>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

constexpr double least_angle = 8 * M_PI / 180;      // rad; below it is an estimate's own error
constexpr double least_lever = 0.03;                // m, likewise
constexpr double axes_tolerance = 40 * M_PI / 180;  // rad, by which a camera may look down or up
constexpr std::size_t least_matches = 10;

double angle_of(const Eigen::Matrix3d& R) {
  return std::acos(std::clamp((R.trace() - 1) / 2, -1.0, 1.0));
}

/// The rotation with the least squared chordal distance to those whose sum this is.
Eigen::Matrix3d mean_rotation(const Eigen::Matrix3d& sum) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d sign(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

struct Fit {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  double scatter = 0;  // rad, RMS
  double rmse = 0;     // m, of the positions
};

double position_rmse(const std::vector<MatchedPose>& matches) {
  double sum = 0;
  for (const MatchedPose& m : matches)
    sum += (m.T_world_truth.translation() - m.T_world_estimate.translation()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(matches.size()));
}

/// The worlds aligned by the positions; R: the truth's body on the estimate's.
Fit turned_body(const std::vector<MatchedPose>& matches) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const MatchedPose& m : matches)
    sum += m.T_world_estimate.linear().transpose() * m.T_world_truth.linear();
  Fit fit{mean_rotation(sum), 0, position_rmse(matches)};
  for (const MatchedPose& m : matches)
    fit.scatter += std::pow(
        angle_of(fit.R.transpose() * m.T_world_estimate.linear().transpose() * m.T_world_truth.linear()), 2);
  fit.scatter = std::sqrt(fit.scatter / static_cast<double>(matches.size()));
  return fit;
}

/// The same body, the worlds aligned by its rotations; R: between the worlds.
Fit same_body(const std::vector<MatchedPose>& matches) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const MatchedPose& m : matches)
    sum += m.T_world_truth.linear() * m.T_world_estimate.linear().transpose();
  Fit fit{mean_rotation(sum), 0, 0};
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(matches.size());
  for (const MatchedPose& m : matches)
    shift += (m.T_world_truth.translation() - fit.R * m.T_world_estimate.translation()) / n;
  std::vector<MatchedPose> moved = matches;
  for (MatchedPose& m : moved) {
    m.T_world_estimate.translation() = fit.R * m.T_world_estimate.translation() + shift;
    m.T_world_estimate.linear() = fit.R * m.T_world_estimate.linear();
    fit.scatter += std::pow(angle_of(m.T_world_estimate.linear().transpose() * m.T_world_truth.linear()), 2);
  }
  fit.scatter = std::sqrt(fit.scatter / n);
  fit.rmse = position_rmse(moved);
  return fit;
}

/// RMS distance of the truth's positions from their mean, m.
double extent(const std::vector<MatchedPose>& matches) {
  const auto n = static_cast<double>(matches.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const MatchedPose& m : matches) mean += m.T_world_truth.translation() / n;
  double sum = 0;
  for (const MatchedPose& m : matches) sum += (m.T_world_truth.translation() - mean).squaredNorm();
  return std::sqrt(sum / n);
}

/// The lever in the estimate's body that leaves the least error of the positions, together with a small
/// correction of the world's alignment: p_truth - p = omega x p + tau + R lever. What the motion does not
/// show (the height of a camera on a robot that keeps to a plane) stays 0.
Eigen::Vector3d fit_lever(const std::vector<MatchedPose>& matches) {
  using Vector9d = Eigen::Matrix<double, 9, 1>;
  Eigen::Matrix<double, 9, 9> H = Eigen::Matrix<double, 9, 9>::Zero();
  Vector9d g = Vector9d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const MatchedPose& m : matches)
    centre += m.T_world_estimate.translation() / static_cast<double>(matches.size());
  for (const MatchedPose& m : matches) {
    Eigen::Matrix<double, 3, 9> J;
    J << -hat(m.T_world_estimate.translation() - centre), Eigen::Matrix3d::Identity(),
        m.T_world_estimate.linear();
    H += J.transpose() * J;
    g += J.transpose() * (m.T_world_truth.translation() - m.T_world_estimate.translation());
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(H), Eigen::ComputeThinU | Eigen::ComputeThinV);
  Vector9d x = Vector9d::Zero();
  for (int i = 0; i < 9; ++i)
    if (svd.singularValues()[i] > 1e-3 * static_cast<double>(matches.size()))
      x += svd.matrixV().col(i) * (svd.matrixU().col(i).dot(g) / svd.singularValues()[i]);
  return x.tail<3>();
}

std::vector<MatchedPose> with_lever(std::vector<MatchedPose> matches, const Eigen::Vector3d& lever) {
  for (MatchedPose& m : matches) m.T_world_estimate.translation() += m.T_world_estimate.linear() * lever;
  return align(matches, find_alignment(matches, Alignment::se3));
}

}  // namespace

std::array<std::string, 3> BodyOffset::axes() const {
  std::array<std::string, 3> names;
  for (int i = 0; i < 3; ++i) {
    int largest = 0;
    const Eigen::Vector3d axis = T_estimate_truth.linear().col(i);
    axis.cwiseAbs().maxCoeff(&largest);
    names[static_cast<std::size_t>(i)] = std::string(axis[largest] < 0 ? "-" : "+") +
                                         std::string("xyz").substr(static_cast<std::size_t>(largest), 1);
  }
  return names;
}

BodyPair body_pair(const BodyOffset& offset) {
  if (!offset.rotated) return BodyPair::same;
  const Eigen::Matrix3d R_robot_camera = optical_axes().linear();
  const Eigen::Matrix3d R = offset.T_estimate_truth.linear();
  if (angle_of(R_robot_camera.transpose() * R) < axes_tolerance) return BodyPair::truth_is_camera;
  if (angle_of(R_robot_camera * R) < axes_tolerance) return BodyPair::estimate_is_camera;
  return BodyPair::other;
}

std::optional<BodyOffset> find_body_offset(const std::vector<MatchedPose>& all) {
  if (all.size() < least_matches) return std::nullopt;
  const std::vector<MatchedPose> matches = align(all, find_alignment(all, Alignment::se3));
  BodyOffset offset;
  Eigen::Vector3d lever = Eigen::Vector3d::Zero();
  std::vector<MatchedPose> moved = matches;
  for (int i = 0; i < 3; ++i) {  // the worlds' correction is linear: it is repeated
    const Eigen::Vector3d step = fit_lever(moved);
    lever += step;
    moved = with_lever(moved, step);
  }
  offset.lever = lever.norm();
  offset.rmse_without = position_rmse(matches);
  offset.rmse_with = position_rmse(moved);
  offset.displaced = offset.lever > least_lever && offset.rmse_with < 0.5 * offset.rmse_without;
  if (offset.displaced) offset.T_estimate_truth.translation() = lever;

  const std::vector<MatchedPose>& placed = offset.displaced ? moved : matches;
  const Fit turned = turned_body(placed), same = same_body(placed);
  offset.angle = angle_of(turned.R);
  offset.scatter = turned.scatter;
  const bool constant = offset.angle > least_angle && turned.scatter < offset.angle / 2;
  // A body that hardly turns, or moves along a line, is explained by another alignment of the worlds.
  const bool explained =
      same.scatter < offset.angle / 3 && same.rmse < 2 * turned.rmse + 0.02 * extent(placed);
  offset.rotated = constant && !explained;
  if (offset.rotated) offset.T_estimate_truth.linear() = turned.R;
  if (!offset.rotated && !offset.displaced) return std::nullopt;
  return offset;
}

}  // namespace lcmslam
