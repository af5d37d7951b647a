// Four particles side by side are what each is alone, whatever the kinds of the measurements.

#include <lcmslam/fastslam/particle_update.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace lcmslam {
namespace {

struct GroupScene {
  Eigen::Isometry3d T_robot_camera = optical_axes();
  std::vector<FeaturePoint> points;
  std::vector<LandmarkMatch> observed;
  std::vector<Particle> particles;
  std::vector<Eigen::Isometry3d> T_world_prior;
};

// Points and bearings; each particle has the landmarks a little elsewhere, and stands a little elsewhere.
GroupScene make_scene(int count) {
  Random random(4);
  GroupScene scene;
  for (int i = 0; i < 20; ++i) {
    FeaturePoint point;
    point.feature = i;
    const Eigen::Vector3d p(random.uniform(1, 4), random.uniform(-2, 2), random.uniform(-1, 1));
    point.measurement.value = p;
    point.measurement.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    if (i % 4 == 3) {
      point.measurement.kind = MeasurementKind::bearing;
      const Eigen::Vector3d ray = scene.T_robot_camera.inverse() * p;
      point.measurement.value << ray.x() / ray.z(), ray.y() / ray.z(), 0;
      point.measurement.covariance.diagonal() << 1e-5, 1e-5, 1;
    }
    scene.points.push_back(point);
    scene.observed.push_back({i, i, 0});
    for (int k = 0; k < count; ++k) {
      if (i == 0) scene.particles.emplace_back();
      LandmarkGaussian landmark;
      landmark.mean = p + 0.01 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
      if (i == 7 && k == 1) landmark.mean.x() += 2;  // not in its gate
      landmark.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      scene.particles[static_cast<std::size_t>(k)].map.edit(static_cast<std::size_t>(i)) = landmark;
    }
  }
  for (int k = 0; k < count; ++k) scene.T_world_prior.push_back(planar_pose(0.01 * k, -0.01 * k, 0.002 * k));
  while (scene.T_world_prior.size() < lane_count) scene.T_world_prior.push_back(scene.T_world_prior.back());
  return scene;
}

class SideBySide : public ::testing::TestWithParam<int> {};

TEST_P(SideBySide, IsTheSameAsOneByOne) {
  const int count = GetParam();
  GroupScene together = make_scene(count), alone = make_scene(count);
  for (GroupScene* scene : {&together, &alone})
    for (FeaturePoint& point : scene->points)
      if (point.is_bearing()) point.measurement.T_robot_camera = &scene->T_robot_camera;
  const FastSlamSettings settings;
  const Matrix6d Q = 1e-4 * Matrix6d::Identity();
  std::vector<Random> streams, streams_alone;
  for (int k = 0; k < count; ++k) {
    streams.emplace_back(9, k);
    streams_alone.emplace_back(9, k);
  }
  std::vector<Verdict> verdicts(static_cast<std::size_t>(count));
  ParticleUpdate(settings, Q, together.observed, together.points)
      .apply(together.particles.data(), streams.data(), count, together.T_world_prior.data(),
             verdicts.data());
  int accepted = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
    std::array<Eigen::Isometry3d, lane_count> T_prior;
    T_prior.fill(alone.T_world_prior[k]);
    Verdict verdict;
    ParticleUpdate(settings, Q, alone.observed, alone.points)
        .apply(&alone.particles[k], &streams_alone[k], 1, T_prior.data(), &verdict);
    EXPECT_EQ(verdict.accepted, verdicts[k].accepted);
    EXPECT_EQ(verdict.count, verdicts[k].count);
    EXPECT_EQ(verdict.distance2, verdicts[k].distance2);
    EXPECT_EQ(alone.particles[k].T_world_robot.matrix(), together.particles[k].T_world_robot.matrix());
    EXPECT_EQ(alone.particles[k].log_weight, together.particles[k].log_weight);
    for (std::size_t slot = 0; slot < alone.points.size(); ++slot)
      EXPECT_TRUE(*alone.particles[k].map.find(slot) == *together.particles[k].map.find(slot)) << slot;
    accepted += verdict.count;
  }
  EXPECT_GE(accepted, 17 * count);
  if (count > 1) {
    EXPECT_FALSE(verdicts[1].accepted[7]);
  }
}

INSTANTIATE_TEST_SUITE_P(Counts, SideBySide, ::testing::Values(1, 2, 3, 4));

// exp(-d^2/2) >= gate: just inside and just outside, with both ways to weigh what is rejected.
TEST(ParticleUpdate, RejectsBeyondTheGate) {
  FastSlamSettings settings;
  settings.proposal = ProposalKind::motion;
  for (const RejectionWeight rejection : {RejectionWeight::floored, RejectionWeight::constant})
    for (const double part : {0.99, 1.01}) {
      settings.rejection = rejection;
      std::vector<FeaturePoint> points(1);
      points[0].measurement.value = Eigen::Vector3d(2, 0, 0);
      points[0].measurement.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      const double gate = std::sqrt(-2 * std::log(settings.gate) * 2e-4);  // m, S = 2e-4
      Particle particle;
      particle.map.edit(0) =
          LandmarkGaussian{Eigen::Vector3d(2, part * gate, 0), 1e-4 * Eigen::Matrix3d::Identity()};
      const CompactLandmark before = *particle.map.find(0);
      std::array<Eigen::Isometry3d, lane_count> T_prior;
      T_prior.fill(Eigen::Isometry3d::Identity());
      Random stream(1);
      Verdict verdict;
      const std::vector<LandmarkMatch> observed = {{0, 0, 0}};
      ParticleUpdate(settings, 1e-16 * Matrix6d::Identity(), observed, points)
          .apply(&particle, &stream, 1, T_prior.data(), &verdict);
      const bool inside = part < 1;
      EXPECT_EQ(verdict.count, inside);
      EXPECT_EQ(*particle.map.find(0) == before, !inside);
      const double log_peak = -1.5 * std::log(2 * M_PI * 2e-4);
      const double expected = inside ? log_peak + part * part * std::log(settings.gate)
                              : rejection == RejectionWeight::floored ? log_peak + std::log(settings.gate)
                                                                      : std::log(settings.p0);
      EXPECT_NEAR(particle.log_weight, expected, 1e-4);
    }
}

}  // namespace
}  // namespace lcmslam
