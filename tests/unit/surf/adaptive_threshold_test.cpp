#include <lcmslam/surf/adaptive_threshold.hpp>

#include <gmock/gmock.h>

#include <cmath>

namespace lcmslam {
namespace {

AdaptiveThresholdSettings settings() {
  AdaptiveThresholdSettings s;
  s.start = 100;
  s.lowest = 10;
  s.highest = 1000;
  s.wanted = 1000;
  return s;
}

/// A scene with so many blobs above a threshold, by a power law.
int blobs(double at_100, double exponent, double threshold) {
  return static_cast<int>(at_100 * std::pow(threshold / 100, -exponent));
}

TEST(AdaptiveThreshold, SettlesNearTheWantedCountForAnyScene) {
  for (const double exponent : {0.5, 1.0, 1.5})
    for (const double at_100 : {400., 1000., 2500.}) {
      AdaptiveThreshold threshold(settings());
      for (int i = 0; i < 30; ++i) threshold.observe(blobs(at_100, exponent, threshold.value()));
      const int found = blobs(at_100, exponent, threshold.value());
      EXPECT_GT(found, 750) << at_100 << " " << exponent;
      EXPECT_LT(found, 1300) << at_100 << " " << exponent;
      const double before = threshold.value();
      threshold.observe(found);
      EXPECT_EQ(threshold.value(), before) << "it rests there";
    }
}

TEST(AdaptiveThreshold, StaysWithinItsBounds) {
  AdaptiveThreshold threshold(settings());
  for (int i = 0; i < 50; ++i) threshold.observe(0);
  EXPECT_EQ(threshold.value(), 10);
  EXPECT_TRUE(threshold.at_lowest());
  for (int i = 0; i < 50; ++i) threshold.observe(1'000'000);
  EXPECT_EQ(threshold.value(), 1000);
  EXPECT_FALSE(threshold.at_lowest());
}

TEST(AdaptiveThreshold, OneOddFrameMovesItByAnOctaveAtMost) {
  AdaptiveThreshold threshold(settings());
  threshold.observe(0);
  EXPECT_EQ(threshold.value(), 50);
  threshold.observe(1'000'000);
  EXPECT_EQ(threshold.value(), 100);
}

TEST(AdaptiveThreshold, RefusesBoundsThatMakeNoSense) {
  auto wrong = settings();
  wrong.lowest = 200;
  EXPECT_THROW(AdaptiveThreshold{wrong}, std::invalid_argument);
  wrong = settings();
  wrong.lowest = 0;
  EXPECT_THROW(AdaptiveThreshold{wrong}, std::invalid_argument);
  wrong = settings();
  wrong.highest = std::nan("");
  EXPECT_THROW(AdaptiveThreshold{wrong}, std::invalid_argument);
  wrong = settings();
  wrong.wanted = 0;
  EXPECT_THROW(AdaptiveThreshold{wrong}, std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
