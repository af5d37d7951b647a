#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <lcmslam/geometry/motion_buffer.hpp>
#include "tests/unit/geometry/random_poses.hpp"

namespace lcmslam {
namespace {

// A chain of noisy increments as a driver accumulates it: S_b = Ad(T_b_a) S_a Ad(T_b_a)^T + Q.
struct Chain {
  std::vector<MotionSample> samples;
  std::vector<Eigen::Isometry3d> increments;
  std::vector<Matrix6d> noise;

  Chain(std::uint64_t seed, int steps) {
    Random random(seed);
    MotionSample s;
    s.utime = 1'000'000;
    samples.push_back(s);
    for (int i = 0; i < steps; ++i) {
      increments.push_back(random_transform(random, 0.3, 0.1));
      noise.push_back(random_covariance(random, 0.01));
      const Matrix6d A = adjoint(increments.back().inverse());
      s.utime += 20'000;
      s.T_odom_robot = s.T_odom_robot * increments.back();
      s.covariance = (A * s.covariance * A.transpose()).eval() + noise.back();
      samples.push_back(s);
    }
  }
  MotionBuffer buffer() const {
    MotionBuffer result;
    for (const auto& s : samples) result.add(s);
    return result;
  }
};

TEST(MotionBuffer, IncrementBetweenNeighboursIsTheOneThatWasAccumulated) {
  const Chain chain(1, 30);
  const MotionBuffer buffer = chain.buffer();
  for (std::size_t i = 0; i < chain.increments.size(); ++i) {
    const auto motion = buffer.between(chain.samples[i].utime, chain.samples[i + 1].utime);
    ASSERT_TRUE(motion);
    EXPECT_LT((motion->T_from_to.matrix() - chain.increments[i].matrix()).norm(), 1e-12);
    EXPECT_LT((motion->covariance - chain.noise[i]).norm(),
              1e-9 * (1 + chain.samples[i + 1].covariance.norm()));
  }
}

// A driver that accumulates its covariance along another path than it sends, as after a correction.
TEST(MotionBuffer, CovarianceIsNeverNegative) {
  MotionSample a, b;
  a.utime = 1, b.utime = 2;
  a.covariance = b.covariance = 0.01 * Matrix6d::Identity();
  b.T_odom_robot.translation().x() = 0.5;  // its heading's uncertainty should have become one of y
  MotionBuffer buffer;
  buffer.add(a);
  buffer.add(b);
  const Matrix6d Q = buffer.between(1, 2)->covariance;
  EXPECT_GE(Q.diagonal().minCoeff(), 0);
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Matrix6d>(Q).eigenvalues().minCoeff(), -1e-15);
  EXPECT_GT(Q.norm(), 0);
}

TEST(MotionBuffer, MotionsChain) {
  const Chain chain(2, 20);
  const MotionBuffer buffer = chain.buffer();
  const Utime a = chain.samples[3].utime, b = chain.samples[9].utime, c = chain.samples[17].utime;
  const auto ab = buffer.between(a, b), bc = buffer.between(b, c), ac = buffer.between(a, c);
  ASSERT_TRUE(ab && bc && ac);
  EXPECT_LT(((ab->T_from_to * bc->T_from_to).matrix() - ac->T_from_to.matrix()).norm(), 1e-12);
  const Matrix6d A = adjoint(bc->T_from_to.inverse());
  const Matrix6d chained = A * ab->covariance * A.transpose() + bc->covariance;
  EXPECT_LT((chained - ac->covariance).norm(), 1e-8 * (1 + chained.norm()));
}

TEST(MotionBuffer, BackwardsIsTheInverse) {
  const Chain chain(3, 10);
  const MotionBuffer buffer = chain.buffer();
  const Utime a = chain.samples[2].utime, b = chain.samples[7].utime;
  const Eigen::Isometry3d loop = buffer.between(a, b)->T_from_to * buffer.between(b, a)->T_from_to;
  EXPECT_LT((loop.matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-12);
}

TEST(MotionBuffer, InterpolatesPoseAndSharesTheCovariance) {
  const Chain chain(4, 5);
  const MotionBuffer buffer = chain.buffer();
  const MotionSample& a = chain.samples[2];
  const Utime between = a.utime + 5'000;  // a quarter
  const auto s = buffer.at(between);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->utime, between);
  const Eigen::Isometry3d expected = interpolate(a.T_odom_robot, chain.samples[3].T_odom_robot, 0.25);
  EXPECT_LT((s->T_odom_robot.matrix() - expected.matrix()).norm(), 1e-12);
  const auto motion = buffer.between(a.utime, between);
  ASSERT_TRUE(motion);
  EXPECT_LT((motion->covariance - 0.25 * chain.noise[2]).norm(), 1e-9 * (1 + a.covariance.norm()));
}

TEST(MotionBuffer, KnowsOnlyItsSpan) {
  const Chain chain(5, 4);
  const MotionBuffer buffer = chain.buffer();
  EXPECT_FALSE(buffer.at(chain.samples.front().utime - 1));
  EXPECT_FALSE(buffer.at(chain.samples.back().utime + 1));
  EXPECT_FALSE(buffer.between(chain.samples.front().utime, chain.samples.back().utime + 1));
  EXPECT_TRUE(buffer.covers(chain.samples.front().utime));
  EXPECT_TRUE(buffer.covers(chain.samples.back().utime));
  EXPECT_FALSE(MotionBuffer().covers(0));
}

TEST(MotionBuffer, ForgetsWhatIsOlderThanItsSpan) {
  MotionBuffer buffer(100'000);
  MotionSample s;
  for (s.utime = 0; s.utime <= 300'000; s.utime += 20'000) buffer.add(s);
  EXPECT_FALSE(buffer.covers(180'000));
  EXPECT_TRUE(buffer.covers(200'000));
  EXPECT_EQ(buffer.newest(), 300'000);
}

// Wheels that were read again after ten seconds tell how far they rolled, not which way the robot took.
TEST(MotionBuffer, NobodyKnowsTheWayOverAGapInTheSamples) {
  MotionBuffer buffer;
  MotionSample s;
  for (const Utime utime : {0, 1'000'000, 3'000'000, 5'000'001, 6'000'000}) {
    s.utime = utime;
    buffer.add(s);
  }
  EXPECT_TRUE(buffer.between(0, 3'000'000));
  EXPECT_TRUE(buffer.between(5'000'001, 6'000'000));
  EXPECT_FALSE(buffer.between(2'900'000, 5'500'000));
  EXPECT_FALSE(buffer.between(4'000'000, 4'500'000));
  EXPECT_FALSE(buffer.between(5'500'000, 2'900'000));
  EXPECT_FALSE(buffer.between(0, 6'000'000));
}

TEST(MotionBuffer, AJumpBackInTimeStartsAfresh) {
  MotionBuffer buffer;
  MotionSample s;
  s.utime = 1000;
  EXPECT_TRUE(buffer.add(s));
  s.utime = 2000;
  EXPECT_TRUE(buffer.add(s));
  s.utime = 1500;
  EXPECT_FALSE(buffer.add(s));
  EXPECT_EQ(buffer.newest(), 1500);
  EXPECT_FALSE(buffer.covers(1400));
}

TEST(MotionBuffer, ASampleThatComesTwiceCountsOnce) {
  MotionBuffer buffer;
  MotionSample s;
  for (const Utime utime : {1000, 2000, 2000, 3000}) {
    s.utime = utime;
    EXPECT_TRUE(buffer.add(s));
  }
  EXPECT_TRUE(buffer.between(1000, 3000));
}

TEST(MotionBuffer, SamplesThatCameTogetherTellNoSpeed) {
  MotionBuffer buffer;
  MotionSample s;
  for (const auto& [utime, x] :
       {std::pair(0, 0.0), std::pair(80, 0.01), std::pair(40'000, 0.02), std::pair(40'080, 0.03)}) {
    s.utime = utime;
    s.T_odom_robot = Eigen::Translation3d(x, 0, 0);
    buffer.add(s);
  }
  const auto later = buffer.at(140'080, 200'000);
  ASSERT_TRUE(later);
  EXPECT_NEAR(later->T_odom_robot.translation().x(), 0.03 + 0.5 * 0.1, 1e-6);
}

}  // namespace
}  // namespace lcmslam
