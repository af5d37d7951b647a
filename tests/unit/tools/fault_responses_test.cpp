// A run that is made up: who told a fault, and what came after it.

#include "tools/study/faults/fault_responses.hpp"

#include <gmock/gmock.h>

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
  const auto responses = fault_responses(faults, run, usual);
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

TEST(FaultResponses, WhatNobodyToldAndWhoNeverCameBackIsSaid) {
  RunRecord usual{{}, poses(0.01), poses(0.01)};
  RunRecord run{{}, poses(0.01, 1e9, 10, 0.5), poses(0.01)};
  const auto responses = fault_responses({{FaultKind::slip, 10, 1, ""}}, run, usual);
  EXPECT_FALSE(responses[0].told);
  EXPECT_FALSE(responses[0].fastslam.found) << "half a metre off is not found";
  EXPECT_TRUE(responses[0].icp.found);
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
