// The study of covariances tells honest mappers from boasting and from timid ones.

#include "tools/study/consistency_study.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {
namespace {

constexpr int honest_runs = 10, honest_poses = 400;

/// A drive of a pose each second whose errors are `boast` times as large as it says; 6: in space, 3: in the
/// plane.
ConsistencyRun simulated_drive(std::uint64_t seed, double boast, int components) {
  Random random(seed);
  const Eigen::Isometry3d T_world_map = planar_pose(3, -2, 1);  // the truth's world is another one
  Matrix6d P = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) P(i, i) = i < 3 ? 1e-4 : 1e-6;
  P(0, 1) = P(1, 0) = 0.5e-4;
  const Matrix6d root = P.llt().matrixL();
  std::vector<MatchedPose> matches;
  for (int k = 0; k < honest_poses; ++k) {
    MatchedPose match;
    match.utime = 1'000'000 * k;
    match.T_world_estimate = planar_pose(0.1 * k, 0, 0.01 * k);
    Vector6d e = Vector6d::Zero();
    for (int i = 0; i < 6; ++i)
      if (k > 0 && (components == 6 || i < 2 || i == 5)) e(i) = boast * random.normal();
    match.T_world_truth = T_world_map * match.T_world_estimate * se3_exp(root * e);
    if (components == 6 && k == 1) match.T_world_estimate.translation().z() += 1e-5;  // not in the plane
    match.covariance = P;
    matches.push_back(match);
  }
  ConsistencyRun run = consistency_run(matches);
  run.scene = "room";
  run.channel = "POSE";
  return run;
}

ConsistencyScore score_of(double boast, int components) {
  std::vector<ConsistencyRun> drives;
  for (int i = 1; i <= honest_runs; ++i)
    drives.push_back(simulated_drive(static_cast<std::uint64_t>(i), boast, components));
  const auto scores = consistency_scores(drives);
  EXPECT_EQ(scores.size(), 1U);
  return scores.at(0);
}

TEST(ConsistencyStudy, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(chi_square_quantile(3, 1.959964), 9.348, 0.1);
  EXPECT_NEAR(chi_square_quantile(6, -1.959964), 1.237, 0.04);  // Wilson and Hilferty: 1.206
  EXPECT_NEAR(chi_square_quantile(60, 1.959964), 83.298, 0.05);
  EXPECT_NEAR(chi_square_quantile(60, -1.959964), 40.482, 0.05);
}

TEST(ConsistencyStudy, QuantilesAreExactWhereFreedomIsLittle) {
  EXPECT_NEAR(chi_square_quantile(3, -1.959964), 0.2158, 1e-4);
  EXPECT_NEAR(chi_square_quantile(1, 1.959964), 5.0239, 1e-4);
}

// A mapper that never had a second pose is no run of six components that kept all bounds.
TEST(ConsistencyStudy, ARunWithoutPosesIsNamedAndCountsForNothing) {
  ConsistencyRun empty = consistency_run({});
  empty.scene = "room";
  empty.channel = "POSE";
  empty.log = "room_7";
  const ConsistencyScore together = consistency_scores({simulated_drive(1, 1, 3), empty}).at(0);
  EXPECT_EQ(together.runs, 1);
  EXPECT_EQ(together.components, 3);
  EXPECT_GT(together.judged, 0U);
  EXPECT_THAT(together.not_judged, ::testing::ElementsAre("room_7"));
  const auto alone = consistency_scores({empty});
  EXPECT_EQ(alone.at(0).runs, 0);
  EXPECT_TRUE(std::isnan(alone.at(0).mean));
  EXPECT_THAT(consistency_table(alone), ::testing::HasSubstr("room_7, POSE: no run"));
}

TEST(ConsistencyStudy, WhereNoSecondIsJudgedNoShareIsKept) {
  ConsistencyRun early = simulated_drive(1, 1, 6), late = simulated_drive(2, 1, 6);
  for (std::size_t i = 0; i < early.nees.size(); ++i) (i < 200 ? late : early).nees[i] = std::nan("");
  const ConsistencyScore score = consistency_scores({early, late}).at(0);
  EXPECT_EQ(score.judged, 0U);
  EXPECT_TRUE(std::isnan(score.inside) && std::isnan(score.above) && std::isnan(score.far_above));
}

// Stand-alone study and report judge the same poses.
TEST(BelievedPoses, AreOfTheFirstMapAndNotOfALostMapper) {
  BelievedPoses poses;
  pose_estimate_t m{};
  for (std::size_t i = 0; i < 6; ++i) m.covariance[7 * i] = 1e-4;
  m.T_map_robot = to_message(Eigen::Isometry3d::Identity());
  const auto say = [&](std::int8_t status, const std::string& frame) {
    m.utime += 100'000;
    m.status = status;
    m.frame = frame;
    poses.hear("ICP_POSE", encode_message(m));
  };
  say(pose_estimate_t::TRACKING, "map");
  say(pose_estimate_t::LOST, "map");
  say(pose_estimate_t::DEGRADED, "map");
  say(pose_estimate_t::TRACKING, "map2");
  const BelievedPath path = poses.paths().at("ICP_POSE");
  ASSERT_EQ(path.path.size(), 2U);
  EXPECT_EQ(path.path[1].utime, 300'000);
  EXPECT_EQ(path.left_out, 2U);

  const ConsistencyRun lost_alone = consistency_run({{0}, {1'000'000}}, {{}, 5}, {});
  EXPECT_TRUE(lost_alone.all.empty());
  EXPECT_EQ(lost_alone.left_out, 5U);
}

TEST(ConsistencyStudy, AnHonestMapperIsInsideTheBand) {
  for (const int components : {3, 6}) {
    const ConsistencyScore honest = score_of(1, components);
    EXPECT_EQ(honest.components, components);
    EXPECT_EQ(honest.runs, honest_runs);
    EXPECT_NEAR(honest.mean, components, 0.1 * components);
    EXPECT_NEAR(honest.inside, 0.95, 0.035);  // 400 seconds: three sigmas
    EXPECT_EQ(honest.far_above, 0);
    EXPECT_NEAR(honest.ratio_rms[0], 1, 0.05);
  }
}

// A filter of the plane may leave it in one drive: each is measured by its own number of components.
TEST(ConsistencyStudy, DrivesInThePlaneAndOutOfItAreHonestTogether) {
  std::vector<ConsistencyRun> drives;
  for (int i = 1; i <= honest_runs; ++i)
    drives.push_back(simulated_drive(static_cast<std::uint64_t>(i), 1, i <= honest_runs / 2 ? 3 : 6));
  const ConsistencyScore mixed = consistency_scores(drives).at(0);
  EXPECT_DOUBLE_EQ(mixed.components, 4.5);
  EXPECT_NEAR(mixed.mean, 4.5, 0.45);
  EXPECT_NEAR(mixed.inside, 0.95, 0.035);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(mixed.within[i], 0.9973, 0.003) << i;
    EXPECT_NEAR(mixed.ratio_rms[i], 1, 0.05) << i;
  }
}

// 2 Phi(3) - 1; of 24000 errors the share scatters by 0.03 %, and by 0.09 % of one component's 4000.
TEST(ConsistencyStudy, OfHonestErrorsThoseOfTheTablesAreWithinThreeSigmas) {
  for (const int components : {3, 6}) {
    const ConsistencyScore honest = score_of(1, components);
    EXPECT_EQ(honest.poses, honest_runs * (honest_poses - 1U));
    EXPECT_NEAR(honest.within_whitened, 0.9973, 0.002);
    for (const std::size_t i : {0U, 1U, 5U}) EXPECT_NEAR(honest.within[i], 0.9973, 0.003) << i;
    EXPECT_EQ(honest.within[2] > 0, components == 6);
  }
  const ConsistencyScore boasting = score_of(2, 6);
  EXPECT_NEAR(boasting.within_whitened, 0.8664, 0.01);  // 2 Phi(1.5) - 1
  for (const double share : boasting.within) EXPECT_NEAR(share, 0.8664, 0.025);
}

// A mapper that gets lost in one drive is not judged by the seconds before alone without a word.
TEST(ConsistencyStudy, SecondsAndPosesThatAreNotJudgedAreCounted) {
  ConsistencyRun whole = simulated_drive(1, 1, 6), lost = simulated_drive(2, 1, 6);
  const std::size_t seconds = whole.nees.size();
  lost.nees.resize(seconds / 2);
  lost.left_out = 7;
  const std::vector<ConsistencyScore> scores = consistency_scores({whole, lost});
  EXPECT_EQ(scores.at(0).judged, seconds / 2 - 1);  // the first pose lies on the truth
  EXPECT_EQ(scores.at(0).seconds, seconds);
  EXPECT_EQ(scores.at(0).left_out, 7U);
  EXPECT_THAT(consistency_table(scores),
              ::testing::HasSubstr(std::to_string(seconds / 2 - 1) + " of " + std::to_string(seconds)));

  std::vector<MatchedPose> matches(5);
  for (std::size_t i = 0; i < matches.size(); ++i) matches[i].utime = static_cast<Utime>(i) * 100'000;
  matches[1].covariance = Matrix6d::Identity();
  matches[2].covariance = Matrix6d::Zero();  // claims to err by nothing
  const ConsistencyRun run = consistency_run(matches);
  EXPECT_EQ(run.all.size(), 1U);
  EXPECT_EQ(run.left_out, 3U);
}

TEST(ConsistencyStudy, WhoBoastsIsAboveItAndWhoIsTimidBelow) {
  const ConsistencyScore boasting = score_of(2, 6), timid = score_of(0.3, 6);
  EXPECT_GT(boasting.above, 0.99);
  EXPECT_GT(boasting.far_above, 0.9);
  EXPECT_LT(timid.inside, 0.01);
  EXPECT_EQ(timid.above, 0);
}

}  // namespace
}  // namespace lcmslam
