// What the particles are weighed by, and what the best particle makes of it.

#include <lcmslam/fastslam/step_observations.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace lcmslam {
namespace {

std::vector<int> slots_of(const std::vector<LandmarkMatch>& matches) {
  std::vector<int> slots;
  for (const LandmarkMatch& match : matches) slots.push_back(match.slot);
  return slots;
}

// Landmarks in slots 0..4, of which 1 and 4 have a known identity; feature 10 + i shows slot i.
class StepObservationsTest : public ::testing::Test {
 protected:
  StepObservationsTest() {
    for (int i = 0; i < 5; ++i) {
      Feature feature;
      feature.landmark_id = i == 1 || i == 4 ? 100 + i : -1;
      index_.add(feature, settings_);
      map_.edit(static_cast<std::size_t>(i));
      FeaturePoint point;
      point.feature = 10 + i;
      point.measurement.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      points_.push_back(point);
    }
    frame_.features.resize(15);
    association_.matches = {{0, 0, 5}, {2, 2, 5}, {3, 3, 5}};
    association_.known = {{1, 1, 0}, {4, 4, 0}};
  }
  StepObservations select() { return select_observations(association_, frame_, points_, map_, settings_); }

  FastSlamSettings settings_;
  LandmarkIndex index_;
  ParticleMap map_;
  FeatureFrame frame_;
  std::vector<FeaturePoint> points_;
  FrameAssociation association_;
};

TEST_F(StepObservationsTest, AllOfKnownIdentityAreUsedAndTheMostInformativeOthers) {
  EXPECT_EQ(slots_of(select().observed), (std::vector<int>{0, 1, 2, 3, 4}));
  settings_.maximum_observations = 1;
  points_[2].measurement.covariance *= 0.1;
  const StepObservations few = select();
  EXPECT_EQ(slots_of(few.observed), (std::vector<int>{1, 2, 4}));
  EXPECT_EQ(slots_of(few.seen), (std::vector<int>{0, 1, 2, 3, 4}));
}

TEST_F(StepObservationsTest, TheBestParticleJudges) {
  settings_.maximum_observations = 2;
  points_[0].measurement.covariance *= 10;  // not used
  StepObservations observations = select();
  ASSERT_EQ(slots_of(observations.observed), (std::vector<int>{1, 2, 3, 4}));
  association_.rejected = {{0, 2, 9}};
  StepResult result;
  Verdict verdict;
  verdict.accepted = {0, 1, 0, 1};
  verdict.count = 2;
  verdict.distance2 = 5;
  EXPECT_TRUE(judge(verdict, association_, points_, index_, observations, result));  // 4 has an identity
  EXPECT_EQ(slots_of(observations.accepted), (std::vector<int>{2, 4}));
  EXPECT_EQ(slots_of(observations.seen), (std::vector<int>{0, 2, 4}));
  EXPECT_EQ(observations.contradicted, std::vector<int>{1}) << "3 is known by its looks alone";
  EXPECT_EQ(result.matched, 3);
  EXPECT_EQ(result.used, 2);
  EXPECT_EQ(result.rejected, 3);
  EXPECT_DOUBLE_EQ(result.mean_distance2, 2.5);
  using Outcome = AssociationOutcome;
  const std::vector<Outcome> expected = {Outcome::unused,   Outcome::rejected, Outcome::accepted,
                                         Outcome::rejected, Outcome::accepted, Outcome::rejected};
  ASSERT_EQ(result.associations.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(result.associations[i].outcome, expected[i]) << i;
  EXPECT_EQ(result.associations[2].feature, 12);
  EXPECT_EQ(result.associations[2].landmark, index_.record(2).id);
  EXPECT_EQ(result.observations.size(), 4U);

  verdict.accepted = {0, 1, 1, 0};
  StepObservations others = select();
  EXPECT_FALSE(judge(verdict, association_, points_, index_, others, result)) << "nobody of known identity";
}

// coth(dt / (2 tau)): exp(-dt / tau) apart they say (1 - rho) / (1 + rho) of independent ones.
TEST_F(StepObservationsTest, CorrelatedErrorsWidenWhatIsMeasuredSoonAgain) {
  const std::vector<LandmarkMatch> observed = {{2, 2, 0}};
  index_.record(2).measured = 1'000'000;
  auto points = points_;
  widen_for_correlation(observed, 1'500'000, 0, index_, points);
  EXPECT_EQ(points[2].measurement.covariance, points_[2].measurement.covariance);
  EXPECT_EQ(index_.record(2).measured, 1'000'000);
  widen_for_correlation(observed, 1'500'000, 2.0, index_, points);
  const double rho = std::exp(-0.5 / 2.0);
  EXPECT_NEAR(points[2].measurement.covariance(0, 0), 1e-4 * (1 + rho) / (1 - rho), 1e-12);
  EXPECT_EQ(points[1].measurement.covariance, points_[1].measurement.covariance);
  EXPECT_EQ(index_.record(2).measured, 1'500'000);
  points = points_;
  widen_for_correlation(observed, 60'000'000, 2.0, index_, points);
  EXPECT_NEAR(points[2].measurement.covariance(2, 2), 1e-4, 1e-9);
}

}  // namespace
}  // namespace lcmslam
