#include <lcmslam/calibration/self/drive_advice.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A head of two cameras 80 mm apart, and what is known of it: mm and degrees, of all axes together.
struct Known {
  HeadModel model;
  BundleResult result;

  Known(double mm, double degrees, double scale = 0.005) : model(two_cameras()) {
    result.priors = result.sigmas = CalibrationPriors().sigmas(model.start);
    result.sigmas[head::fx] = 0.3;
    result.sigmas[head::depth_scale] = scale;
    for (int i = 0; i < 3; ++i) {
      result.sigmas[static_cast<std::size_t>(head::tx + i)] = 1e-3 * mm / std::sqrt(3);
      result.sigmas[static_cast<std::size_t>(head::rx + i)] = degrees * M_PI / 180 / std::sqrt(3);
    }
  }

  static RgbdCalibration two_cameras() {
    RgbdCalibration c;
    c.colour.width = 640, c.colour.height = 480, c.colour.fx = c.colour.fy = 550;
    c.depth = c.colour;
    c.T_colour_depth.translation() << 0.08, 0, 0;
    return c;
  }
};

TEST(DriveAdvice, ALongDriveNeedsNone) {
  const Known k(1.2, 0.078);
  EXPECT_THAT(drive_advice(k.model, k.result, 150, 240), IsEmpty());
}

TEST(DriveAdvice, AShortDriveIsToGoOn) {
  Known k(1.58, 0.089);
  EXPECT_THAT(drive_advice(k.model, k.result, 60, 240),
              ElementsAre(AllOf(HasSubstr("direction is within 0.1 degrees with a probability of 71 %"),
                                HasSubstr("(60 now)"), HasSubstr("some 1"))));
  EXPECT_THAT(drive_advice(k.model, k.result, 60, 90), ElementsAre(HasSubstr("calibrate pair does")))
      << "more than are taken";
  k.result.sigmas[head::fx] = 2;
  EXPECT_THAT(drive_advice(k.model, k.result, 60, 240).front(),
              HasSubstr("the focal length is within 0.3 %"));
}

// The world's scale is not seen, and the distance of both cameras has it.
TEST(DriveAdvice, WhatNoDriveTellsIsForTheBoard) {
  const Known k(2.5, 0.075, 0.03);
  EXPECT_THAT(drive_advice(k.model, k.result, 60, 240),
              ElementsAre(AllOf(HasSubstr("place is within 2 mm"), HasSubstr("calibrate pair does"))));
}

TEST(SelfDoubts, WhatTellsAHeadIsNone) {
  const Known k(1.2, 0.078);
  EXPECT_THAT(self_doubts(k.result, {}, 20), IsEmpty());
}

TEST(SelfDoubts, AFewKeyframesAreNoCalibration) {
  const Known k(1.2, 0.078);
  EXPECT_THAT(self_doubts(k.result, {}, 19), ElementsAre(HasSubstr("only 19 keyframes")));
}

TEST(SelfDoubts, ARecordingThatTellsNothingIsNone) {
  Known k(1.2, 0.078);
  k.result.sigmas = k.result.priors;
  EXPECT_THAT(self_doubts(k.result, {}, 150), ElementsAre(HasSubstr("tells nothing of the head")));
}

}  // namespace
}  // namespace lcmslam
