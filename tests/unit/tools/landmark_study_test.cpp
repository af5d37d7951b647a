// What the study of landmarks says of a run.

#include "tools/study/landmark_study.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/unit/evaluation/path_samples.hpp"

namespace lcmslam {
namespace {

// A map of what is easy only has a small error: it says of how many landmarks that is.
TEST(LandmarkStudy, LandmarksThatAreMissingAreCounted) {
  LandmarkRecording recording;
  recording.landmark_truth = {{6, {1, 2}}, {7, {3, 4}}, {8, {-2, 5}}};
  LandmarkRun run;
  run.online = run.smoothed = recording.truth = testing::curved_path(100);
  run.landmarks[7] = {3.03, 4.04, 0};
  run.landmarks[99] = {0, 0, 0};  // nobody's
  LandmarkStudyResult result;
  result.scores = {score(recording, recording.truth, run, 1)};
  EXPECT_NEAR(result.scores[0].landmarks, 0.05, 1e-9);
  EXPECT_EQ(result.scores[0].found, 1U);
  EXPECT_EQ(result.scores[0].existing, 3U);
  EXPECT_THAT(landmark_table(result), ::testing::HasSubstr("1 of 3"));
}

TEST(LandmarkStudy, WhereNothingWasSmoothedNoErrorIsShown) {
  LandmarkRecording recording;
  LandmarkRun run;
  run.online = recording.truth = testing::curved_path(100);
  LandmarkStudyResult result;
  result.scores = {score(recording, recording.truth, run, 1)};
  EXPECT_TRUE(std::isnan(result.scores[0].smoothed.rmse));
  std::string last = landmark_table(result);
  last = last.substr(last.find("worst"));
  std::istringstream worst(last);
  std::string row, online, online_max, smoothed;
  worst >> row >> online >> online_max >> smoothed;
  EXPECT_EQ(online, "0.000");
  EXPECT_EQ(smoothed, "-");
  const nlohmann::json json = nlohmann::json::parse(landmark_json(result).dump());
  EXPECT_TRUE(json.at("runs")[0].at("smoothed").at("rmse_m").is_null());
}

TEST(LandmarkStudy, ARunThatBeganANewMapIsInNoMedian) {
  LandmarkStudyResult result;
  result.scores.resize(3);
  result.scores[0].online.rmse = 0.25;
  for (const std::size_t i : {1U, 2U}) {
    result.scores[i].online.rmse = 0.0625;
    result.scores[i].restarts = 1;
  }
  const std::string table = landmark_table(result);
  const std::string median = table.substr(table.find("median"));
  EXPECT_THAT(median, ::testing::HasSubstr("0.250"));
  EXPECT_THAT(median, ::testing::Not(::testing::HasSubstr("0.062")));
  EXPECT_THAT(median, ::testing::HasSubstr("2 of 3 runs began a new map"));
}

}  // namespace
}  // namespace lcmslam
