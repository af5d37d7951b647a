// The covariances that are published.

#include <lcmslam/fastslam/pose_covariance.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

FastSlamSettings three_particles() {
  FastSlamSettings settings;
  settings.particles = 3;
  settings.mount_error = {0.003, 0.002};
  return settings;
}

// What the head's place leaves open of height, roll and pitch, which a planar filter does not look for.
Matrix6d held_by_the_plane() {
  Matrix6d expected = Matrix6d::Zero();
  expected.diagonal() << 0, 0, 9e-6, 4e-6, 4e-6, 0;
  expected.diagonal().array() += 1e-8;  // no pose is exact
  return expected;
}

Eigen::Isometry3d mounted() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.2, -0.1, 1.1;
  T.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()));
  return T * optical_axes();
}

/// Where a planar filter puts a robot whose head it believes to sit at mounted(): the camera's place and
/// heading.
Eigen::Isometry3d in_plane(const Eigen::Isometry3d& T_world_camera) {
  const Eigen::Matrix3d R = T_world_camera.linear() * mounted().linear().transpose();
  const double heading = std::atan2(R(1, 0), R(0, 0));
  const Eigen::Vector3d place =
      T_world_camera.translation() - planar_pose(0, 0, heading) * mounted().translation();
  return planar_pose(place.x(), place.y(), heading);
}

// Against the landmarks in sight: the particles' spread and the head's place. Seen from the start: nothing
// there, and then what the ensemble says.
TEST(PoseCovariance, GrowsFromWhereTheMapBegins) {
  PoseCovariance covariance(three_particles());
  const ParticleSet particles(three_particles());
  ParticleSet::Estimate estimate;
  estimate.spread = 0.01 * Matrix6d::Identity();
  Matrix6d mount = Matrix6d::Zero();
  mount.diagonal() << 9e-6, 9e-6, 9e-6, 4e-6, 4e-6, 4e-6;
  EXPECT_TRUE(covariance.in_map(estimate).isApprox(estimate.spread + mount, 1e-12));
  const auto from_start = [&] {
    return covariance.from_start(particles, particles.weights(), estimate, mounted());
  };
  EXPECT_TRUE(from_start().isApprox(held_by_the_plane(), 1e-9));
  Motion slide;
  slide.covariance(0, 0) = 1;
  covariance.move(slide);
  EXPECT_NEAR(from_start()(0, 0), 1, 0.4);
}

// A robot that turned round after a metre: draws of where its head sits, and the way that is told with where
// it should sit.
TEST(PoseCovariance, HoldsWhatTheHeadsPlaceMakesOfTheWay) {
  const FastSlamSettings settings = three_particles();
  Random random(5);
  for (const bool planar : {true, false}) {
    PoseCovariance covariance(settings);
    if (!planar) covariance.leave_plane();
    const ParticleSet particles(settings);
    ParticleSet::Estimate estimate;
    estimate.T_world_robot = planar_pose(1, 0.5, 3);
    constexpr int draws = 4000;
    Matrix6d sum = Matrix6d::Zero();
    for (int k = 0; k < draws; ++k) {
      Vector6d m;
      for (int i = 0; i < 6; ++i) m(i) = random.normal(0, i < 3 ? 0.003 : 0.002);
      const Eigen::Isometry3d T_built = mounted() * se3_exp(m), T_told_built = T_built * mounted().inverse();
      const Eigen::Isometry3d T_told =
          planar ? in_plane(T_built).inverse() * in_plane(estimate.T_world_robot * T_built)
                 : T_told_built.inverse() * estimate.T_world_robot * T_told_built;
      const Vector6d e = se3_log(T_told.inverse() * estimate.T_world_robot);
      sum += e * e.transpose() / draws;
    }
    const Matrix6d P = covariance.from_start(particles, particles.weights(), estimate, mounted());
    const std::vector<int> free = planar ? std::vector<int>{0, 1, 5} : std::vector<int>{0, 1, 2, 3, 4, 5};
    for (const int i : free) {
      for (const int j : free)
        EXPECT_NEAR(P(i, j), sum(i, j), 0.1 * std::sqrt(P(i, i) * P(j, j)) + 1e-7) << i << " " << j;
    }
    EXPECT_GT(P(0, 0), 3 * 9e-6);
    // Tilts of a head 1.1 m above the ground lean a robot in space, and move none aside that stands.
    if (planar) {
      EXPECT_LT(P(0, 0), 5 * 9e-6);
    }
  }
}

// Held in the hand, the camera is the robot.
TEST(PoseCovariance, HoldsNoMountWhereThereIsNone) {
  PoseCovariance covariance(three_particles());
  covariance.leave_plane();
  const ParticleSet particles(three_particles());
  ParticleSet::Estimate estimate;
  estimate.T_world_robot = planar_pose(1, 0.5, 3);
  EXPECT_TRUE(covariance.from_start(particles, particles.weights(), estimate, optical_axes()).isZero(1e-7));
}

// Particles drawn from the path's posterior: their own poses as seen from their own beginnings say it all.
TEST(PoseCovariance, IsThatOfThePathsWhereTheirBeginningsAreKnown) {
  PoseCovariance covariance(three_particles());
  ParticleSet particles(three_particles());
  std::vector<PathSample> samples(3);
  for (int k = 0; k < 3; ++k)
    samples[static_cast<std::size_t>(k)].T_world_start = planar_pose(0.3 * (k - 1), 0, 0);
  particles.draw_anew(samples, CalibrationCovariance::Zero(), [](std::int32_t) { return -1; });
  ParticleSet::Estimate estimate;
  estimate.spread = 100 * Matrix6d::Identity();
  Matrix6d expected = held_by_the_plane();
  expected(0, 0) += 2 * 0.09 / 3;
  EXPECT_TRUE(
      covariance.from_start(particles, particles.weights(), estimate, mounted()).isApprox(expected, 1e-9));
}

}  // namespace
}  // namespace lcmslam
