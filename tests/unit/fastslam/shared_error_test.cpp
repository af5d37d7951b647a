// The error that particles share, as the map remembers it.

#include <lcmslam/fastslam/smoothing/shared_error.hpp>

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

namespace lcmslam {
namespace {

constexpr int minimum_consensus = 8;

class SharedErrorTest : public ::testing::Test {
 protected:
  std::vector<LandmarkMatch> make(int count) {
    std::vector<LandmarkMatch> made;
    for (int i = 0; i < count; ++i) made.push_back({i, index_.add(Feature(), FastSlamSettings()), 0});
    error_.create(made);
    return made;
  }
  void see(const std::vector<LandmarkMatch>& landmarks, const Eigen::Isometry3d& T_world_robot) {
    error_.observe(landmarks, minimum_consensus, T_world_robot, spread_);
  }
  double variance() const { return error_.at(Eigen::Isometry3d::Identity())(0, 0); }

  LandmarkIndex index_;
  SharedError error_;
  Matrix6d spread_ = 1e-4 * Matrix6d::Identity();
  const Eigen::Isometry3d here_ = Eigen::Isometry3d::Identity();
};

TEST_F(SharedErrorTest, IsNoneBeforeTheFirstLandmark) {
  error_.observe({}, minimum_consensus, here_, spread_);
  EXPECT_EQ(error_.at(here_), Matrix6d::Zero());
}

// The pose's own spread divided by the observations: landmarks are means of theirs.
TEST_F(SharedErrorTest, FallsWithTheObservationsOfTheSameLandmarks) {
  const auto landmarks = make(100);
  for (int i = 0; i < 3; ++i) see(landmarks, here_);
  const double few = variance();
  for (int i = 0; i < 100; ++i) see(landmarks, here_);
  constexpr double observations = 1 + 3 + 100;
  EXPECT_LT(variance(), 0.1 * few);
  EXPECT_NEAR(variance(), 1e-4 / observations, 0.2e-4 / observations);
}

// From generation to generation it grows as a random walk; the first landmarks bring it back.
TEST_F(SharedErrorTest, GrowsWithEachGenerationOfLandmarksAndShrinksAtTheLoop) {
  const auto first = make(100);
  for (int i = 0; i < 10; ++i) see(first, here_);
  double before = variance();
  for (int generation = 0; generation < 10; ++generation) {
    const auto next = make(100);
    for (int i = 0; i < 10; ++i) see(next, here_);
    EXPECT_GT(variance(), before);
    before = variance();
  }
  EXPECT_GT(before, 5 * 1e-5);
  for (int i = 0; i < 10; ++i) see(first, here_);
  EXPECT_LT(variance(), 0.2 * before);
}

// A heading that is wrong where landmarks were made is a position that is wrong far from there.
TEST_F(SharedErrorTest, TurnsIntoPositionWithTheWayFromThere) {
  const auto landmarks = make(1000);
  see(landmarks, here_);
  Eigen::Isometry3d there = Eigen::Isometry3d::Identity();
  there.translation().x() = 10;
  const Matrix6d P = error_.at(there);
  EXPECT_NEAR(P(1, 1), P(0, 0) + 100 * P(5, 5), 1e-4 * P(1, 1));
  EXPECT_EQ(P, P.transpose());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(P).eigenvalues().minCoeff(), -1e-6 * P(1, 1));
}

TEST_F(SharedErrorTest, ALandmarkOrTwoDoNotTellThePose) {
  const auto first = make(2);
  for (int generation = 0; generation < 5; ++generation) see(make(100), here_);
  const double before = variance();
  see(first, here_);
  EXPECT_GT(variance(), 0.7 * before);
}

}  // namespace
}  // namespace lcmslam
