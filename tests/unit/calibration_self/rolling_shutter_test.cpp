// One rolling shutter for both images, of rows that were found in each.

#include <lcmslam/calibration/self/rolling_shutter.hpp>

#include <gmock/gmock.h>

#include <lcmslam/calibration/self/self_report.hpp>

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct Ms {
  double found, sigma;
};

/// A head that was told of `start` ms.
struct FoundRows {
  HeadModel model;
  BundleResult result;
  BundleSettings settings;

  FoundRows(double start, Ms colour, Ms depth) : model(head_with(start)) {
    result.priors = result.sigmas = CalibrationPriors().sigmas(model.start);
    result.covariance = Eigen::MatrixXd::Zero(head::count, head::count);
    model.values[head::colour_rows] = 1e-3 * colour.found,
    result.sigmas[head::colour_rows] = 1e-3 * colour.sigma;
    model.values[head::depth_rows] = 1e-3 * depth.found, result.sigmas[head::depth_rows] = 1e-3 * depth.sigma;
  }
  static RgbdCalibration head_with(double ms) {
    RgbdCalibration c;
    c.colour.width = 640, c.colour.height = 480, c.colour.fx = c.colour.fy = 550;
    c.depth = c.colour;
    c.rolling_shutter = 1e-3 * ms;
    return c;
  }

  double written() const {
    return 1e3 * observed_head(model, result, settings).calibration().rolling_shutter;
  }
  std::string report() const { return report_text(model, result, settings); }
};

// A short drive: 8.6 ms apart, and both may err by as much.
TEST(RollingShutter, IsTheMeanOfRowsThatAgreeByTheirSigmas) {
  for (const double start : {0.0, 30.0}) {
    const FoundRows rows(start, {26.2, 2}, {34.8, 4});
    EXPECT_NEAR(rows.written(), (4 * 26.2 + 34.8) / 5, 1e-9) << "the surer one counts four times as much";
    EXPECT_THAT(rows.report(), Not(HasSubstr("note:")));
  }
}

TEST(RollingShutter, OfTheOneThatIsSeenWhereTheOtherMayBeAlike) {
  EXPECT_NEAR(FoundRows(0, {26.2, 2}, {9, 15}).written(), 26.2, 1e-9) << "depth's rows are not observed";
  EXPECT_NEAR(FoundRows(0, {9, 15}, {33, 4}).written(), 33, 1e-9) << "nor colour's";
}

TEST(RollingShutter, ThatTwoImagesContradictStaysAndIsTold) {
  const FoundRows rows(5, {29.5, 2.7}, {0.4, 3});
  EXPECT_NEAR(rows.written(), 5, 1e-9);
  EXPECT_THAT(rows.report(), AllOf(HasSubstr("note: rolling_shutter stays 5.0 ms"),
                                   HasSubstr("29.5 +- 2.7 ms"), HasSubstr("0.4 +- 3.0 ms")));
}

TEST(RollingShutter, ThatNothingTellsStaysSilently) {
  const FoundRows rows(5, {20, 15}, {0, 15});
  EXPECT_NEAR(rows.written(), 5, 1e-9);
  EXPECT_THAT(rows.report(), Not(HasSubstr("note:")));
}

// Rows of a global shutter come out a little on either side of 0.
TEST(RollingShutter, IsNeverNegative) {
  EXPECT_EQ(FoundRows(0, {-1.2, 2}, {-0.4, 2}).written(), 0);
}

}  // namespace
}  // namespace lcmslam
