#include <lcmslam/evaluation/consistency.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

// 95 % quantiles of chi square with 2, 3 and 6 degrees of freedom.
constexpr double inside_2 = 5.991, inside_3 = 7.815, inside_6 = 12.592;

using Components = std::vector<int>;    // of a twist
const Components in_plane = {0, 1, 5};  // x, y, heading

Components components_of(const std::vector<MatchedPose>& matches) {
  const Eigen::Isometry3d T_first_world = matches.front().T_world_estimate.inverse();
  const bool planar = std::all_of(matches.begin(), matches.end(), [&](const MatchedPose& match) {
    const Eigen::Isometry3d T = T_first_world * match.T_world_estimate;
    return std::abs(T.translation().z()) < 1e-6 && T.linear()(2, 2) > 1 - 1e-9;
  });
  return planar ? in_plane : Components{0, 1, 2, 3, 4, 5};
}

Eigen::VectorXd error_of(const MatchedPose& match, const Components& rows) {
  return se3_log(match.T_world_estimate.inverse() * match.T_world_truth)(rows);
}

double nees(const Eigen::VectorXd& e, const Eigen::MatrixXd& P) {
  return e.dot(P.llt().solve(e));
}

// Gauss-Newton on the sum of NEES over a motion xi of the estimate's world, expressed in the frame T_0 of its
// first pose (of worlds that share the ground: at that pose, upright), and one eta of its body:
// T_i <- T_0 exp(xi) T_0^-1 T_i exp(eta), e_i <- e_i - Ad((T_0^-1 T_i)^-1) xi - eta. What the way does not
// tell of them stays 0. Returns the truth's body on the estimate's.
Eigen::Isometry3d fit_frames(std::vector<MatchedPose>& matches, const Components& rows,
                             const ConsistencyFit& fit) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  const bool upright = fit.world == WorldFit::ground;
  const Components columns = fit.world == WorldFit::none ? Components{} : upright ? in_plane : rows;
  const auto world = static_cast<Eigen::Index>(columns.size());
  const Eigen::Index body = fit.body ? n : 0;
  Eigen::Isometry3d T_estimate_truth = Eigen::Isometry3d::Identity();
  for (int iteration = 0; iteration < 5; ++iteration) {
    Eigen::Isometry3d T_first = matches.front().T_world_estimate;
    if (upright) T_first.linear().setIdentity();
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(world + body, world + body);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(world + body);
    for (const MatchedPose& match : matches) {
      Eigen::MatrixXd A(n, world + body);
      A.leftCols(world) = adjoint(match.T_world_estimate.inverse() * T_first)(rows, columns);
      if (fit.body) A.rightCols(n).setIdentity();
      const Eigen::MatrixXd P = (*match.covariance)(rows, rows);
      const Eigen::MatrixXd weighted = P.llt().solve(A);
      information += A.transpose() * weighted;
      gradient += weighted.transpose() * error_of(match, rows);
    }
    const Eigen::VectorXd step = information.completeOrthogonalDecomposition().solve(gradient);
    Vector6d xi = Vector6d::Zero(), eta = Vector6d::Zero();
    xi(columns) = step.head(world);
    eta(rows).head(body) = step.tail(body);
    const Eigen::Isometry3d T_moved = T_first * se3_exp(xi) * T_first.inverse();
    for (MatchedPose& match : matches)
      match.T_world_estimate = T_moved * match.T_world_estimate * se3_exp(eta);
    T_estimate_truth = T_estimate_truth * se3_exp(eta);
  }
  return T_estimate_truth;
}

}  // namespace

std::optional<Consistency> consistency(std::vector<MatchedPose> matches, const ConsistencyFit& fit) {
  if (matches.empty()) return std::nullopt;
  const Components rows = components_of(matches);
  const auto tells_nothing = [&](const MatchedPose& match) {
    return !match.covariance ||
           Eigen::MatrixXd((*match.covariance)(rows, rows)).llt().info() != Eigen::Success;
  };
  matches.erase(std::remove_if(matches.begin(), matches.end(), tells_nothing), matches.end());
  if (matches.empty()) return std::nullopt;

  Consistency result;
  if (fit.world != WorldFit::none || fit.body) result.T_estimate_truth = fit_frames(matches, rows, fit);
  result.components = static_cast<int>(rows.size());
  const bool planar = rows.size() == 3;
  const Eigen::Index position = planar ? 2 : 3;
  const auto n = static_cast<double>(matches.size());
  std::vector<double> values;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows.size()));
  for (const MatchedPose& match : matches) {
    const Eigen::VectorXd e = error_of(match, rows);
    const Eigen::MatrixXd P = (*match.covariance)(rows, rows);
    values.push_back(nees(e, P));
    squares += e.cwiseAbs2().cwiseQuotient(P.diagonal()) / n;
    result.inside += (values.back() < (planar ? inside_3 : inside_6)) / n;
    const double off = nees(e.head(position), P.topLeftCorner(position, position));
    result.position_inside += (off < (planar ? inside_2 : inside_3)) / n;
  }
  result.nees = statistics(std::move(values));
  for (const double square : squares) result.error_over_sigma.push_back(std::sqrt(square));
  return result;
}

}  // namespace lcmslam
