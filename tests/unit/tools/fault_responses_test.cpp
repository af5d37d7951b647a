// A run that is made up: who told a fault, and what came after it.

#include "tools/study/faults/fault_responses.hpp"

#include <gmock/gmock.h>
#include <cmath>
#include <nlohmann/json.hpp>

#include <lcmslam/messages/geometry_messages.hpp>
#include "tools/study/faults/kills_study.hpp"

namespace lcmslam {
namespace {

using Held = MapperWatch::Held;

std::vector<Held> poses(double error, double lost_from = 1e9, double lost_to = 0, double later = -1) {
  std::vector<Held> poses;
  for (int i = 0; i < 300; ++i) {
    const double at = 0.1 * i;
    const bool lost = at >= lost_from && at < lost_to;
    poses.push_back({at, !lost, at >= lost_to && later >= 0 ? later : error, 0});
  }
  return poses;
}

TEST(FaultResponses, SayWhenItWasToldAndWhatCameAfter) {
  RunRecord usual{{}, poses(0.01), poses(0.02)};
  RunRecord run{{{3, "before"}, {10.55, "surf: dark"}, {25, "icp restarted"}},
                poses(0.01, 10.2, 16, 0.03),
                poses(0.02)};
  const std::vector<Fault> faults = {{FaultKind::black, 10, 5, ""}, {FaultKind::killed, 24, 0, "icp"}};
  const auto responses = fault_responses(faults, run, {usual});
  ASSERT_EQ(responses.size(), 2U);
  EXPECT_NEAR(responses[0].told.value(), 0.2, 0.06);
  EXPECT_EQ(responses[0].by, "FASTSLAM_POSE");
  EXPECT_NEAR(responses[0].fastslam.found.value(), 1, 0.11);
  EXPECT_NEAR(responses[0].fastslam.error, 0.03, 1e-9);
  EXPECT_NEAR(responses[0].fastslam.usual, 0.01, 1e-9);
  EXPECT_NEAR(responses[0].icp.found.value(), 0, 0.11);
  EXPECT_NEAR(responses[1].told.value(), 1, 1e-9);
  EXPECT_EQ(responses[1].by, "icp restarted");
}

// Live, runs that nobody disturbed differ by more than many a fault makes.
TEST(FaultResponses, StandBesideAllUndisturbedRuns) {
  const std::vector<RunRecord> usual = {{{}, poses(0.003), poses(0.02)}, {{}, poses(0.004), poses(0.01)}};
  const RunRecord run{{}, poses(0.01), poses(0.02)};
  const auto responses = fault_responses({{FaultKind::slip, 10, 1, ""}}, run, usual);
  EXPECT_NEAR(responses.at(0).fastslam.error, 0.01, 1e-9);
  EXPECT_NEAR(responses.at(0).fastslam.usual, std::sqrt((0.003 * 0.003 + 0.004 * 0.004) / 2), 1e-9);
  EXPECT_NEAR(responses.at(0).fastslam.worst, 0.004, 1e-9);
  EXPECT_NEAR(responses.at(0).icp.worst, 0.02, 1e-9);
}

TEST(FaultResponses, WhatWasToldBeforeIsNotOfTheFault) {
  const RunRecord usual{{}, poses(0.01), poses(0.01)};
  RunRecord run = usual;
  run.alarms = {
      {8.5, "surf: inputs' losses"}, {10.1, "surf: inputs' losses"}, {10.6, "icp: of_other_senders"}};
  const auto responses = fault_responses({{FaultKind::stranger, 10, 3, ""}}, run, {usual});
  EXPECT_NEAR(responses[0].told.value(), 0.6, 1e-9);
  EXPECT_EQ(responses[0].by, "icp: of_other_senders");
}

// The first seconds of a drive are a straight way: what is wrong later must not be how the way's roll was
// guessed.
TEST(MapperWatch, LaysAMapByDirectionsToo) {
  Trajectory truth;
  MapperWatch watch;
  for (int i = 0; i < 200; ++i) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = i < 100 ? Eigen::Vector3d(0.01 * i, 0, 0) : Eigen::Vector3d(1, 0.02 * (i - 100), 0);
    T.translation().y() += 1e-4 * (i * 7 % 5 - 2);
    T.translation().z() += 1e-4 * (i * 3 % 7 - 3);
    truth.push_back({1'000'000 + 100'000 * i, T});
    pose_estimate_t pose{};
    pose.utime = truth.back().utime;
    pose.frame = "map";
    pose.status = pose_estimate_t::TRACKING;
    T.translation().y() += 0.001 * (i % 3 - 1);  // it errs a little, in its way's height and side
    T.translation().z() += 0.001 * (i % 5 - 2);
    pose.T_map_robot = to_message(T);
    watch.add(pose, 0.1 * i);
  }
  for (const Held& held : watch.held(truth, 1'000'000 + 100'000 * 80))
    EXPECT_LT(held.error, 0.004) << held.at;
}

TEST(FaultResponses, WhatNobodyToldAndWhoNeverCameBackIsSaid) {
  RunRecord usual{{}, poses(0.01), poses(0.01)};
  RunRecord run{{}, poses(0.01, 1e9, 10, 0.5), poses(0.01)};
  const auto responses = fault_responses({{FaultKind::slip, 10, 1, ""}}, run, {usual});
  EXPECT_FALSE(responses[0].told);
  EXPECT_FALSE(responses[0].fastslam.found) << "half a metre off is not found";
  EXPECT_TRUE(responses[0].icp.found);
}

/// A run of the study of kills whose `icp` was killed three times.
nlohmann::json killed_run(const nlohmann::json& kills) {
  nlohmann::json run = {{"run", "killed"},
                        {"faults", nlohmann::json::array()},
                        {"memory_bytes", nlohmann::json::array({1e6})},
                        {"memory_bytes_of", nlohmann::json::object()},
                        {"kills", kills}};
  for (const char* count :
       {"sessions", "sessions_joined", "keyframes_told", "keyframes_lost", "keyframes_unjudged",
        "landmarks_told", "landmarks_lost", "landmarks_unjudged", "keyframes_placed"})
    run[count] = 1;
  for (const char* figure : {"fastslam_gap_s", "icp_gap_s", "map_error_m", "stop_s"}) run[figure] = 1.5;
  return {{"runs", nlohmann::json::array({run})}};
}

// A kill after which a mapper was never right again is the worst of all, and no gap in the table.
TEST(KillsTable, WhatNeverCameIsTheMost) {
  nlohmann::json kill = {{"process", "icp"},         {"fastslam_silent_s", 0.5}, {"icp_silent_s", 0.5},
                         {"icp_right_s", 0.25},      {"icp_not_kept_s", 0.5},    {"fastslam_not_kept_s", 0.5},
                         {"fastslam_right_s", 0.75}, {"told_s", 0.125}};
  const nlohmann::json whole = kill;
  kill.erase("icp_right_s");
  const std::string some = kills_table(killed_run({whole, whole, kill}));
  EXPECT_THAT(some, ::testing::HasSubstr("0.25 / never (2 of 3)"));
  EXPECT_THAT(some, ::testing::HasSubstr("0.75 / 0.75 "));
  EXPECT_THAT(some, ::testing::HasSubstr("laid on the truth by its own first pose"));
  kill.erase("told_s");
  EXPECT_THAT(kills_table(killed_run({kill, kill, kill})),
              ::testing::ContainsRegex("icp +3 +never / never \\(0 of 3\\)"));
}

TEST(FaultResponses, TroubleIsWhatAStatusTellsThatTheOneBeforeDidNot) {
  status_t before{};
  before.process = "surf";
  before.pid = 1;
  before.detail = "fine";
  status_t now = before;
  EXPECT_EQ(trouble_told(before, now), "");
  now.values.push_back({"stamps_refused", 1});
  EXPECT_EQ(trouble_told(before, now), "surf: stamps_refused");
  EXPECT_EQ(trouble_told(now, now), "");
  now = before;
  now.inputs.resize(1);
  now.inputs[0].decode_errors = 2;
  EXPECT_EQ(trouble_told(before, now), "surf: inputs' losses");
  now = before;
  now.detail = "the depth image shows nothing";
  EXPECT_EQ(trouble_told(before, now), "surf: the depth image shows nothing");
  now.pid = 2;
  EXPECT_EQ(trouble_told(before, now), "surf restarted");
}

}  // namespace
}  // namespace lcmslam
