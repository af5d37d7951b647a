// The covariances that are published.

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

// Against the landmarks in sight: the particles' spread. Seen from the start: what the ensemble says.
TEST(PoseCovariance, AddsWhatNothingElseTells) {
  PoseCovariance covariance(three_particles());
  const ParticleSet particles(three_particles());
  ParticleSet::Estimate estimate;
  estimate.spread = 0.01 * Matrix6d::Identity();
  EXPECT_TRUE(covariance.in_map(estimate).isApprox(estimate.spread + unmodelled(), 1e-12));
  EXPECT_TRUE(covariance.from_start(particles, particles.weights(), estimate).isApprox(unmodelled(), 1e-12));
  Motion slide;
  slide.covariance(0, 0) = 1;
  covariance.move(slide);
  EXPECT_NEAR(covariance.from_start(particles, particles.weights(), estimate)(0, 0), 1.1, 0.5);
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
  Matrix6d expected = unmodelled();
  expected(0, 0) += 2 * 0.09 / 3;
  EXPECT_TRUE(covariance.from_start(particles, particles.weights(), estimate).isApprox(expected, 1e-9));
}

}  // namespace
}  // namespace lcmslam
