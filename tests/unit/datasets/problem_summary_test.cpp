#include <lcmslam/datasets/problem_summary.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(ProblemSummary, OneLineForEachKindWithItsCountInTheirOrder) {
  EXPECT_THAT(summarise_problems({"rgb/7.png: is missing",
                                  "depth/1.png: is 32x24, by the calibration it must be 64x48",
                                  "depth/2.png: is missing", "rgb/9.png: is damaged",
                                  "depth/3.png: is 16x12, by the calibration it must be 64x48"}),
              ElementsAre("2 times, first rgb/7.png: is missing",
                          "2 times, first depth/1.png: is 32x24, by the calibration it must be 64x48",
                          "rgb/9.png: is damaged"));
}

TEST(ProblemSummary, NoProblemNoLine) {
  EXPECT_THAT(summarise_problems({}), IsEmpty());
}

}  // namespace
}  // namespace lcmslam
