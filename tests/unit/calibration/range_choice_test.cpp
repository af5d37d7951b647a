// What `calibrate pair` leaves of what `calibrate tof` found of the ranges.

#include "tools/calibrate/range_choice.hpp"

#include <gmock/gmock.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Fitted to ranges of a camera with this error, which are told to 0.8 mm.
RangeErrorFit fit_of(const DepthError& truth, double nearest, double farthest) {
  Random random(1, 5);
  constexpr double sigma = 0.0008;
  constexpr int count = 120;
  std::vector<RangeSample> samples;
  for (int i = 0; i < count; ++i) {
    const double range = nearest + (farthest - nearest) * i / (count - 1);
    samples.push_back({range, truth.at(range) + random.normal(0, sigma), sigma});
  }
  return fit_range_error(samples);
}

DepthError wiggling() {
  return {0.012, 0, 0.012, 1.5, 0.4};
}

double worst_of(const DepthError& error) {
  double worst = 0;
  for (double r = 0.5; r <= 4; r += 0.01) worst = std::max(worst, std::abs(error.at(r) - wiggling().at(r)));
  return worst;
}

TEST(RangeChoice, AFitOfAFewRangesReplacesNoWiggle) {
  const DepthError base = fit_of(wiggling(), 0.5, 3.2).error;
  ASSERT_LT(worst_of(base), 0.003);
  const RangeErrorFit fit = fit_of(wiggling(), 0.9, 1.5);
  ASSERT_GT(worst_of(fit.error), 0.01);
  const RangeChoice choice = choose_range_error(base, fit);
  EXPECT_TRUE(choice.error == base);
  EXPECT_THAT(choice.kept, ElementsAre(HasSubstr("0.90 to 1.50 m")));
}

TEST(RangeChoice, AFitThatLostTheWiggleIsNotTaken) {
  const RangeErrorFit flat = fit_of({0.02, 0, 0, 1, 0}, 0.5, 3.2);
  ASSERT_EQ(flat.error.wiggle, 0);
  const RangeChoice choice = choose_range_error(wiggling(), flat);
  EXPECT_TRUE(choice.error == wiggling());
  EXPECT_THAT(choice.kept, ElementsAre(HasSubstr("no wiggle")));
}

TEST(RangeChoice, AScaleThatIsNotFittedIsNotLost) {
  DepthError base = wiggling();
  base.scale = 0.01;
  EXPECT_TRUE(choose_range_error(base, fit_of(base, 0.5, 3.2)).error == base);
}

TEST(RangeChoice, AsGoodAFitIsTaken) {
  DepthError base = wiggling();
  base.offset += 0.01;
  const RangeErrorFit fit = fit_of(wiggling(), 0.5, 3.2);
  const RangeChoice choice = choose_range_error(base, fit);
  EXPECT_TRUE(choice.error == fit.error);
  EXPECT_THAT(choice.kept, IsEmpty());
}

TEST(RangeChoice, WhereNothingWasKnownAnyFitIsTaken) {
  const RangeErrorFit fit = fit_of(wiggling(), 0.9, 1.5);
  EXPECT_TRUE(choose_range_error({}, fit).error == fit.error);
}

TEST(RangeChoice, TiltsStay) {
  DepthError tilted;
  tilted.tilt_x = 0.01, tilted.tilt_y = -0.02;
  const RangeErrorFit fit = fit_of(wiggling(), 0.5, 3.2);
  const RangeChoice choice = choose_range_error(tilted, fit);
  EXPECT_EQ(choice.error.tilt_x, 0.01);
  EXPECT_EQ(choice.error.tilt_y, -0.02);
  EXPECT_EQ(choice.error.wiggle, fit.error.wiggle);
  EXPECT_THAT(choice.kept, ElementsAre(HasSubstr("tilt")));
}

}  // namespace
}  // namespace lcmslam
