#include <lcmslam/fastslam/pose_covariance.hpp>

#include <cmath>

#include <lcmslam/fastslam/pose_space.hpp>

namespace lcmslam {
namespace {

// m and rad: no pose is told to be exact. In six dimensions an estimate is surest along some direction by
// what the measurements' model leaves out: without more than in the plane fr1_rpy's NEES was twice as large.
constexpr double least_sigma = 0.0001, least_free_sigma = 0.0003;

// Of a camera's wrong place on a robot that is held in the plane, what moves the camera and not the robot: it
// rises, and tilts about itself.
Matrix6d held_by_plane(const Eigen::Isometry3d& T_robot_camera) {
  const Eigen::Vector3d up = T_robot_camera.linear().row(2).transpose();
  Matrix6d held = Matrix6d::Zero();
  held.topLeftCorner<3, 3>() = up * up.transpose();
  held.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() - up * up.transpose();
  return held;
}

}  // namespace

PoseCovariance::PoseCovariance(const FastSlamSettings& settings)
    : mount_error_(settings.mount_error),
      planar_(settings.planar),
      sensor_error_(settings),
      ensemble_(settings) {
  mount_.diagonal().head<3>().setConstant(std::pow(mount_error_.translation_sigma, 2));
  mount_.diagonal().tail<3>().setConstant(std::pow(mount_error_.rotation_sigma, 2));
}

void PoseCovariance::leave_plane() {
  planar_ = false;
  ensemble_.leave_plane();
}

std::vector<EnsembleObservation> PoseCovariance::with_errors(const std::vector<LandmarkMatch>& matches,
                                                             const MeasuredStep& step) {
  std::vector<EnsembleObservation> observations;
  observations.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    const FeaturePoint& point = step.points[static_cast<std::size_t>(match.point)];
    observations.push_back(
        {match.slot, point.measurement, *step.map.find(static_cast<std::size_t>(match.slot)),
         sensor_error_.draw(point, step.frame, {match.slot, step.index.record(match.slot).id},
                            step.T_world_robot, step.twist)});
  }
  return observations;
}

void PoseCovariance::observe(const std::vector<LandmarkMatch>& accepted, const MeasuredStep& step,
                             const std::optional<Matrix6d>& prior) {
  ensemble_.observe(with_errors(accepted, step), step.T_world_robot, prior);
}

void PoseCovariance::create(const std::vector<LandmarkMatch>& created, const MeasuredStep& step) {
  ensemble_.create(with_errors(created, step), step.T_world_robot);
}

// Particles drawn from the whole path's posterior know where their paths began: their poses as seen from
// there lie about the estimate as the truth does. (The mean square about the estimate and not the variance:
// the smoother holds the world where it was published to be, not at the first pose.) Others have forgotten
// it, and the ensemble remembers.
Matrix6d PoseCovariance::from_start(const ParticleSet& particles, const std::vector<double>& weights,
                                    const ParticleSet::Estimate& estimate,
                                    const Eigen::Isometry3d& T_robot_camera) const {
  const Matrix6d by_measurements = particles.start_known()
                                       ? particles.mean_square_from_start(weights, estimate.T_world_robot)
                                       : ensemble_.pose();
  Matrix6d P = by_measurements + by_mount(estimate.T_world_robot, T_robot_camera);
  P.diagonal().array() += std::pow(planar_ ? least_sigma : least_free_sigma, 2);
  return P;
}

// The world begins at the robot's first pose. What a planar filter holds to be zero (height, roll and pitch)
// is off as the head's place is.
Matrix6d PoseCovariance::by_mount(const Eigen::Isometry3d& T_start_robot,
                                  const Eigen::Isometry3d& T_robot_camera) const {
  const Eigen::Isometry3d T_first_now = T_robot_camera.inverse() * T_start_robot * T_robot_camera;
  const Vector6d sigmas = mount_error_.sigmas(T_robot_camera);
  Matrix6d moved = Matrix6d::Zero();
  if (planar_) moved = held_by_plane(T_robot_camera) * mount_lever(T_first_now) * sigmas.asDiagonal();
  Matrix6d P = mount_error(T_first_now, T_robot_camera, sigmas, moved);
  if (planar_) P = PoseSpace<3>::expand(PoseSpace<3>::reduce(P));
  if (planar_) P.diagonal().segment<3>(2) = mount_.diagonal().segment<3>(2);
  return P;
}

Eigen::Matrix3d PoseCovariance::of_landmark(int slot, const ParticleSet& particles) const {
  return particles.start_known() ? particles.mean_square_from_start(slot) : ensemble_.landmark(slot);
}

}  // namespace lcmslam
