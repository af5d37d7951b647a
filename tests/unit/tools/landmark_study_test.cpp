// What the study of landmarks says of a run.

#include "tools/study/landmark_study.hpp"

#include <gmock/gmock.h>

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

}  // namespace
}  // namespace lcmslam
