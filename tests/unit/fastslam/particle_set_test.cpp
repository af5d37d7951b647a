// The particles alone: what a step, resampling and drawing anew do to them.

#include <lcmslam/fastslam/particle_set.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <set>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/resampling.hpp>

namespace lcmslam {
namespace {

// Landmarks around the origin, measured as 3-D points without error from where the robot is.
struct Surroundings {
  std::vector<Eigen::Vector3d> landmarks;
  double sigma = 0.01;  // m, of a measurement

  explicit Surroundings(int count, std::uint64_t seed = 1) {
    Random random(seed);
    for (int i = 0; i < count; ++i)
      landmarks.emplace_back(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(0, 2));
  }
  std::vector<FeaturePoint> seen_from(const Eigen::Isometry3d& T_world_robot) const {
    std::vector<FeaturePoint> points(landmarks.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].feature = static_cast<int>(i);
      points[i].measurement.value = T_world_robot.inverse() * landmarks[i];
      points[i].measurement.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    }
    return points;
  }
  std::vector<LandmarkMatch> matches() const {
    std::vector<LandmarkMatch> matches;
    for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) matches.push_back({i, i, 0});
    return matches;
  }
};

FastSlamSettings settings_of(int particles) {
  FastSlamSettings settings;
  settings.particles = particles;
  settings.way_scale_sigma = settings.heading_scale_sigma = settings.heading_per_m_sigma = 0;
  settings.side_per_m_sigma = 0;
  return settings;
}

Motion forward(double metres, double sigma = 0.05) {
  Motion motion;
  motion.T_from_to = planar_pose(metres, 0, 0);
  motion.covariance = sigma * sigma * Matrix6d::Identity();
  return motion;
}

// One step forwards without observations: the particles spread as the odometry says.
ParticleSet spread_out(const FastSlamSettings& settings, double sigma = 0.05) {
  ParticleSet particles(settings);
  particles.propose_weigh_update({particles.predict(forward(0.2, sigma)).covariance, {}, {}}, {}, {});
  particles.choose_best();
  return particles;
}

TEST(ParticleSet, WithoutObservationsSpreadsAsTheOdometrySays) {
  const ParticleSet particles = spread_out(settings_of(4000));
  const std::vector<double> weights = particles.weights();
  EXPECT_NEAR(effective_sample_size(weights), 4000, 1e-6);
  const ParticleSet::Estimate estimate = particles.estimate(weights);
  EXPECT_NEAR(estimate.T_world_robot.translation().x(), 0.2, 5 * 0.05 / std::sqrt(4000));
  for (const int i : {0, 1, 5}) EXPECT_NEAR(estimate.spread(i, i), 0.05 * 0.05, 0.15 * 0.05 * 0.05) << i;
  for (const int i : {2, 3, 4}) EXPECT_NEAR(estimate.spread(i, i), 0, 1e-12) << i;  // it stays in the plane
}

// Each particle has the landmarks where it saw them; those that then fit the map best weigh most.
TEST(ParticleSet, ObservationsDrawTheEstimateToThePoseThatTheySay) {
  for (const ProposalKind proposal : {ProposalKind::motion, ProposalKind::measurement}) {
    FastSlamSettings settings = settings_of(2000);
    settings.proposal = proposal;
    const Surroundings surroundings(12);
    ParticleSet particles(settings);
    particles.make_landmarks(surroundings.matches(), surroundings.seen_from(Eigen::Isometry3d::Identity()));
    const Eigen::Isometry3d truth = planar_pose(0.23, -0.04, 0.03);  // the odometry says 0.2 m straight on
    const Verdict verdict =
        particles.propose_weigh_update({particles.predict(forward(0.2)).covariance, {}, {}},
                                       surroundings.matches(), surroundings.seen_from(truth));
    EXPECT_EQ(verdict.count, 12);
    EXPECT_EQ(std::count(verdict.accepted.begin(), verdict.accepted.end(), 1), 12);
    const ParticleSet::Estimate estimate = particles.estimate(particles.choose_best());
    const Vector6d error = se3_log(truth.inverse() * estimate.T_world_robot);
    EXPECT_LT(error.head<3>().norm(), 0.012) << static_cast<int>(proposal);
    EXPECT_LT(error.tail<3>().norm(), 0.012) << static_cast<int>(proposal);
    EXPECT_LT(std::sqrt(estimate.spread(0, 0)), 0.02);
    // Seen twice, a landmark is known better than once.
    for (const LandmarkMatch& match : surroundings.matches()) {
      const double variance = particles.best().map.find(static_cast<std::size_t>(match.slot))->variance();
      EXPECT_LT(variance, 0.8 * 3 * surroundings.sigma * surroundings.sigma);
    }
  }
}

TEST(ParticleSet, WhatLiesOutsideOfTheGateIsRejectedAndNotLearned) {
  const Surroundings surroundings(12);
  ParticleSet particles(settings_of(100));
  const auto here = surroundings.seen_from(Eigen::Isometry3d::Identity());
  particles.make_landmarks(surroundings.matches(), here);
  std::vector<FeaturePoint> points = here;
  points[5].measurement.value.x() += 1;
  const Verdict verdict = particles.propose_weigh_update(
      {particles.predict(forward(0, 0.001)).covariance, {}, {}}, surroundings.matches(), points);
  EXPECT_EQ(verdict.count, 11);
  EXPECT_FALSE(verdict.accepted[5]);
  particles.choose_best();
  EXPECT_LT((particles.best().map.find(5)->mean - surroundings.landmarks[5]).norm(), 0.01);
}

// A pose found in the map counts for all, wherever they were; a motion that observations agree on replaces
// the odometry's.
TEST(ParticleSet, PriorsOfObservationsReplaceTheOdometrys) {
  ParticleSet particles = spread_out(settings_of(500));
  particles.predict(forward(0.2));
  const Matrix6d narrow = 1e-6 * Matrix6d::Identity();
  particles.propose_weigh_update({narrow, planar_pose(-1, 0, 0), {}}, {}, {});
  EXPECT_NEAR(particles.estimate(particles.weights()).T_world_robot.translation().x(), 0.2 - 1, 0.02);
  const Eigen::Isometry3d found = planar_pose(3, 4, 1);
  particles.predict(forward(0.2));
  particles.propose_weigh_update({narrow, planar_pose(-1, 0, 0), found}, {}, {});
  for (const Particle& particle : particles.particles())
    EXPECT_LT((particle.T_world_robot.translation() - found.translation()).norm(), 0.01);
}

class Schemes : public ::testing::TestWithParam<ResamplingScheme> {};

// Mean and covariance of the pose before, by weights, and after, by count.
TEST_P(Schemes, ResamplingKeepsWhatTheWeightsSay) {
  FastSlamSettings settings = settings_of(5000);
  settings.resampling = GetParam();
  settings.resample_fraction = 1;
  settings.proposal = ProposalKind::motion;  // the weights differ widely
  Surroundings surroundings(3);
  surroundings.sigma = 0.1;
  ParticleSet particles(settings);
  particles.make_landmarks(surroundings.matches(), surroundings.seen_from(Eigen::Isometry3d::Identity()));
  particles.propose_weigh_update({particles.predict(forward(0.2)).covariance, {}, {}}, surroundings.matches(),
                                 surroundings.seen_from(planar_pose(0.24, 0.03, 0)));
  const std::vector<double> weights = particles.choose_best();
  const double effective = effective_sample_size(weights);
  ASSERT_LT(effective, 4500);
  ASSERT_GT(effective, 300);
  const ParticleSet::Estimate before = particles.estimate(weights);
  ASSERT_TRUE(particles.resample_when_due(weights));
  const std::vector<double> equal = particles.weights();
  for (const double weight : equal) EXPECT_DOUBLE_EQ(weight, 1. / 5000);
  const ParticleSet::Estimate after = particles.estimate(equal);
  const Vector6d moved = se3_log(before.T_world_robot.inverse() * after.T_world_robot);
  for (const int i : {0, 1, 5}) {
    const double sigma = std::sqrt(before.spread(i, i));
    EXPECT_LT(std::abs(moved(i)), 5 * sigma / std::sqrt(effective)) << i;
    EXPECT_NEAR(after.spread(i, i), before.spread(i, i), 0.2 * before.spread(i, i)) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Schemes,
                         ::testing::Values(ResamplingScheme::multinomial, ResamplingScheme::systematic,
                                           ResamplingScheme::stratified, ResamplingScheme::residual));

// With its map.
TEST(ParticleSet, AfterResamplingTheBestIsTheHeaviestOfBefore) {
  FastSlamSettings settings = settings_of(200);
  settings.resample_fraction = 1;
  settings.proposal = ProposalKind::motion;
  const Surroundings surroundings(6);
  ParticleSet particles(settings);
  particles.make_landmarks(surroundings.matches(), surroundings.seen_from(Eigen::Isometry3d::Identity()));
  particles.propose_weigh_update({particles.predict(forward(0.2)).covariance, {}, {}}, surroundings.matches(),
                                 surroundings.seen_from(planar_pose(0.2, 0, 0)));
  const std::vector<double> weights = particles.choose_best();
  const auto heaviest = std::max_element(weights.begin(), weights.end()) - weights.begin();
  EXPECT_EQ(particles.best_index(), heaviest);
  const Particle before = particles.best();
  particles.resample_when_due(weights);
  EXPECT_EQ(particles.best().T_world_robot.matrix(), before.T_world_robot.matrix());
  for (const LandmarkMatch& match : surroundings.matches()) {
    const auto slot = static_cast<std::size_t>(match.slot);
    EXPECT_EQ(particles.best().map.find(slot)->mean, before.map.find(slot)->mean);
  }
}

TEST(ParticleSet, IsResampledWhenTheEffectiveSampleSizeFallsBelowTheFraction) {
  for (const double fraction : {0.5, 1.0}) {
    FastSlamSettings settings = settings_of(10);
    settings.resample_fraction = fraction;
    ParticleSet particles = spread_out(settings);
    std::vector<double> weights(10, 0.1);
    EXPECT_EQ(particles.resample_when_due(weights), fraction == 1.0);  // 1: every step
    std::fill(weights.begin(), weights.end(), 0.0);
    weights[3] = weights[4] = weights[5] = 1. / 3;
    EXPECT_TRUE(particles.resample_when_due(weights));
  }
}

TEST(ParticleSet, IsCoalescedWhenFewLineagesAreLeft) {
  FastSlamSettings settings = settings_of(100);
  settings.rejuvenation_lineages = 0.25;
  ParticleSet particles = spread_out(settings);
  EXPECT_FALSE(particles.coalesced());
  std::vector<double> weights(100, 0);
  for (int k = 0; k < 30; ++k) weights[static_cast<std::size_t>(k)] = 1. / 30;
  particles.resample_when_due(weights);
  EXPECT_FALSE(particles.coalesced()) << "thirty of a hundred";
  std::fill(weights.begin(), weights.end(), 0.0);
  weights[0] = weights[99] = 0.5;
  particles.resample_when_due(weights);
  EXPECT_TRUE(particles.coalesced());
}

TEST(ParticleSet, DrawnAnewItIsWhatTheSamplesAre) {
  ParticleSet particles = spread_out(settings_of(3));
  std::vector<PathSample> samples(3);
  for (int k = 0; k < 3; ++k) {
    PathSample& sample = samples[static_cast<std::size_t>(k)];
    sample.T_world_robot = planar_pose(k, 0, 0);
    sample.T_world_start = planar_pose(0, 0.1 * k, 0);
    sample.landmarks[7].mean = Eigen::Vector3d(10 + k, 0, 0);
    sample.landmarks[8].mean = Eigen::Vector3d(20, 0, 0);
  }
  EXPECT_FALSE(particles.start_known());
  particles.draw_anew(samples, 1e-6 * CalibrationCovariance::Identity(),
                      [](std::int32_t identity) { return identity == 7 ? 2 : -1; });
  EXPECT_TRUE(particles.start_known());
  EXPECT_EQ(particles.best_index(), 0);
  for (int k = 0; k < 3; ++k) {
    const Particle& particle = particles.particles()[static_cast<std::size_t>(k)];
    EXPECT_EQ(particle.T_world_robot.translation().x(), k);
    EXPECT_EQ(particle.map.find(2)->mean.x(), 10 + k);
    EXPECT_EQ(particle.lineage, k);
  }
  // As seen from where their paths began they lie at (k, -0.1 k): about (1, 0) in the mean square.
  const Matrix6d square = particles.mean_square_from_start(particles.weights(), planar_pose(1, 0, 0));
  EXPECT_NEAR(square(0, 0), 2. / 3, 1e-9);
  EXPECT_NEAR(square(1, 1), (0.01 + 0.04) / 3, 1e-9);
  particles.forget_start();
  EXPECT_FALSE(particles.start_known());
}

TEST(ParticleSet, DeformedItsLandmarksArePlacedOrCarried) {
  const Surroundings surroundings(3);
  ParticleSet particles(settings_of(20));
  particles.make_landmarks(surroundings.matches(), surroundings.seen_from(Eigen::Isometry3d::Identity()));
  const Eigen::Isometry3d T = planar_pose(0.5, 0, 0.2);
  particles.deform(T, {{0, Eigen::Vector3d(1, 2, 3)}}, {2});
  for (const Particle& particle : particles.particles()) {
    EXPECT_EQ(particle.map.find(0)->mean, Eigen::Vector3d(1, 2, 3));
    EXPECT_LT((particle.map.find(1)->mean - surroundings.landmarks[1]).norm(), 1e-12);
    EXPECT_LT((particle.map.find(2)->mean - T * surroundings.landmarks[2]).norm(), 1e-12);
    EXPECT_TRUE(particle.T_world_robot.isApprox(T, 1e-12));
  }
}

// Enough landmarks and particles that threads share the work, and a last part that is not full.
TEST(ParticleSet, ThreadsDoNotMatter) {
  const int before = cv::getNumThreads();
  const Surroundings surroundings(60);
  std::vector<ParticleSet> sets;
  for (const int threads : {1, 2, 4}) {
    cv::setNumThreads(threads);
    FastSlamSettings settings;
    settings.particles = 99;
    settings.resample_fraction = 1;
    ParticleSet& particles = sets.emplace_back(settings);
    particles.make_landmarks(surroundings.matches(), surroundings.seen_from(Eigen::Isometry3d::Identity()));
    for (int i = 1; i <= 5; ++i) {
      particles.propose_weigh_update({particles.predict(forward(0.2)).covariance, {}, {}},
                                     surroundings.matches(),
                                     surroundings.seen_from(planar_pose(0.21 * i, 0, 0)));
      particles.resample_when_due(particles.choose_best());
    }
  }
  cv::setNumThreads(before);
  std::set<double> different;
  for (std::size_t k = 0; k < sets[0].size(); ++k) {
    different.insert(sets[0].particles()[k].T_world_robot.translation().x());
    for (const std::size_t other : {1U, 2U}) {
      const Particle &a = sets[0].particles()[k], &b = sets[other].particles()[k];
      EXPECT_EQ(a.T_world_robot.matrix(), b.T_world_robot.matrix());
      EXPECT_EQ(a.calibration, b.calibration);
      for (std::size_t slot = 0; slot < 60; ++slot) EXPECT_TRUE(*a.map.find(slot) == *b.map.find(slot));
    }
  }
  EXPECT_GT(different.size(), 10U);  // else it proves nothing
}

}  // namespace
}  // namespace lcmslam
