#include <lcmslam/geometry/local_frame.hpp>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace lcmslam {
namespace {

constexpr double farthest = 3;   // sigmas beside the odometry in one step
constexpr double least = 1e-12;  // m^2, rad^2: added, so that what is not free does no harm

}  // namespace

void LocalFrame::advance(const Eigen::Isometry3d& T_map_robot, const Motion& motion) {
  if (std::exchange(started_, true)) {
    // How the mapper saw the robot move, T_from_to exp(beside).
    const Eigen::Isometry3d T_map_predicted = T_map_local_ * T_local_robot_ * motion.T_from_to;
    const Vector6d beside = se3_log(T_map_predicted.inverse() * T_map_robot);
    Matrix6d P = motion.covariance;
    P.diagonal().array() += least;
    const double sigmas = std::sqrt(beside.dot(P.llt().solve(beside)));
    const Vector6d moved = sigmas > farthest ? Vector6d(farthest / sigmas * beside) : beside;
    T_local_robot_ = T_local_robot_ * motion.T_from_to * se3_exp(moved);
    T_local_robot_.linear() = Eigen::Quaterniond(T_local_robot_.linear()).normalized().toRotationMatrix();
  }
  T_map_local_ = T_map_robot * T_local_robot_.inverse();
}

}  // namespace lcmslam
