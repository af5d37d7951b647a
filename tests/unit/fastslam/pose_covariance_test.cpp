// The covariance that is published: spread, shared error and what no particle knows of.

#include <lcmslam/fastslam/pose_covariance.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

FastSlamSettings three_particles() {
  FastSlamSettings settings;
  settings.particles = 3;
  settings.shared_translation_sigma = 0.3;
  settings.shared_rotation_sigma = 0.2;
  return settings;
}

Matrix6d unmodelled() {
  Matrix6d expected = Matrix6d::Zero();
  expected.diagonal() << 0.09, 0.09, 0.09, 0.04, 0.04, 0.04;
  return expected;
}

TEST(PoseCovariance, AddsWhatNoParticleKnowsOf) {
  const PoseCovariance covariance(three_particles());
  const ParticleSet particles(three_particles());
  ParticleSet::Estimate estimate;
  estimate.spread = 0.01 * Matrix6d::Identity();
  const Matrix6d expected = estimate.spread + unmodelled();
  EXPECT_TRUE(covariance.in_map(estimate).isApprox(expected, 1e-12));
  EXPECT_TRUE(covariance.from_start(particles, particles.weights(), estimate).isApprox(expected, 1e-12));
}

// Landmarks that were made by a robot that knew its pose badly: who sees them knows it no better.
TEST(PoseCovariance, AddsTheSharedErrorSeenFromTheStartOnly) {
  PoseCovariance covariance(three_particles());
  const ParticleSet particles(three_particles());
  ParticleSet::Estimate wide, narrow;
  wide.spread = 0.01 * Matrix6d::Identity();
  std::vector<LandmarkMatch> landmarks;
  for (int slot = 0; slot < 100; ++slot) landmarks.push_back({slot, slot, 0});
  covariance.create(landmarks);
  covariance.observe(landmarks, wide);
  EXPECT_TRUE(covariance.in_map(narrow).isApprox(unmodelled(), 1e-12));
  const Matrix6d from_start = covariance.from_start(particles, particles.weights(), narrow);
  EXPECT_NEAR(from_start(0, 0) - 0.09, 0.01, 0.002);
}

// Particles drawn from the path's posterior: their own poses as seen from their own beginnings say it all.
TEST(PoseCovariance, IsThatOfThePathsWhereTheirBeginningsAreKnown) {
  PoseCovariance covariance(three_particles());
  ParticleSet particles(three_particles());
  std::vector<PathSample> samples(3);
  for (int k = 0; k < 3; ++k)
    samples[static_cast<std::size_t>(k)].T_world_start = planar_pose(0.3 * (k - 1), 0, 0);
  particles.draw_anew(samples, Eigen::Matrix3d::Zero(), [](std::int32_t) { return -1; });
  ParticleSet::Estimate estimate;
  estimate.spread = 100 * Matrix6d::Identity();
  Matrix6d expected = unmodelled();
  expected(0, 0) += 2 * 0.09 / 3;
  EXPECT_TRUE(covariance.from_start(particles, particles.weights(), estimate).isApprox(expected, 1e-9));
}

}  // namespace
}  // namespace lcmslam
