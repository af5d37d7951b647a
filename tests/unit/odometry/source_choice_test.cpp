#include <lcmslam/odometry/source_choice.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

constexpr Utime second = 1'000'000;

TEST(SourceChoice, WheelsAreTakenAtOnce) {
  SourceChoice choice(2);
  choice.heard(OdometrySource::visual, 5 * second);
  EXPECT_FALSE(choice.chosen());
  choice.heard(OdometrySource::wheels, 1'000 * second);  // whatever their clock says
  EXPECT_EQ(choice.chosen(), OdometrySource::wheels);
}

TEST(SourceChoice, ALesserSourceMustSpeakForTheWholePatience) {
  SourceChoice choice(2);
  choice.heard(OdometrySource::visual, 10 * second);
  choice.heard(OdometrySource::visual, 12 * second - 1);
  EXPECT_FALSE(choice.chosen());
  choice.heard(OdometrySource::visual, 12 * second);
  EXPECT_EQ(choice.chosen(), OdometrySource::visual);
}

TEST(SourceChoice, TheBestOfThoseThatSpokeIsTaken) {
  SourceChoice choice(2);
  choice.heard(OdometrySource::visual, 10 * second);
  choice.heard(OdometrySource::external, 11 * second);
  choice.heard(OdometrySource::external, 11 * second + 1);
  choice.heard(OdometrySource::visual, 12 * second);
  EXPECT_EQ(choice.chosen(), OdometrySource::external);
}

TEST(SourceChoice, ClocksOfDifferentSourcesAreNotCompared) {
  SourceChoice choice(2);
  choice.heard(OdometrySource::external, 1'700'000'000 * second);
  choice.heard(OdometrySource::visual, 3 * second);
  EXPECT_FALSE(choice.chosen());
  choice.heard(OdometrySource::visual, 4 * second);
  EXPECT_FALSE(choice.chosen());
  choice.heard(OdometrySource::external, 1'700'000'002 * second);
  EXPECT_EQ(choice.chosen(), OdometrySource::external);
}

TEST(SourceChoice, AFirstStampThatWasWrongDelaysNothingForEver) {
  SourceChoice choice(2);
  choice.heard(OdometrySource::visual, 9'000 * second);
  choice.heard(OdometrySource::visual, 10 * second);
  choice.heard(OdometrySource::visual, 12 * second);
  EXPECT_EQ(choice.chosen(), OdometrySource::visual);
}

TEST(SourceChoice, StaysOnceMade) {
  SourceChoice choice(0);
  choice.heard(OdometrySource::visual, 1);
  choice.heard(OdometrySource::wheels, 2);
  EXPECT_EQ(choice.chosen(), OdometrySource::visual);
}

// A joystick's driver says once, at its start, that nobody moves it.
TEST(SourceChoice, WhoSpokeOnceIsNoBetterSource) {
  SourceChoice choice(2);
  choice.heard(OdometrySource::twist, 10 * second);
  for (int i = 0; i <= 110 && !choice.chosen(); ++i)
    choice.heard(OdometrySource::external, 10 * second + i * second / 50);
  EXPECT_EQ(choice.chosen(), OdometrySource::external);
}

}  // namespace
}  // namespace lcmslam
