// What a depth camera errs by at each range, learned from a corridor that it drives through.

#include <lcmslam/planes/range_error.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/wiggling_camera.hpp"

namespace lcmslam {
namespace {

using testing_scene::corridor;
using testing_scene::measured;
using testing_scene::tof_camera;
using testing_scene::view;
using testing_scene::Wave;
using testing_scene::wiggle;

double nothing(double) {
  return 0;
}

/// Ten seconds through the scene, turning to both sides.
RangeError after_a_drive(const testing_scene::Scene& scene, const Wave& wave, std::uint64_t seed = 1,
                         const RgbdCalibration& calibration = tof_camera(),
                         const RangeErrorSettings& settings = {}) {
  Random random(seed);
  RangeError error(calibration, settings);
  for (int i = 0; i < 25; ++i) {
    const Eigen::Isometry3d T = view(0.15 * i, 0.2 * std::sin(0.3 * i), 0.4 * std::sin(0.5 * i));
    error.learn(measured(scene, calibration, T, wave, random), 400'000 * i);
  }
  return error;
}

double rms_left(const RangeError& error, const Wave& wave) {
  double sum = 0;
  int count = 0;
  for (double range = 1.5; range < 5; range += 0.05, ++count)
    sum += std::pow(error.at(range) - wave(range), 2);
  return std::sqrt(sum / count);
}

TEST(RangeError, AWiggleIsLearnedFromWallsAndFloor) {
  EXPECT_LT(rms_left(after_a_drive(corridor(), wiggle), wiggle), 0.0015);  // of 0.0042
}

TEST(RangeError, NothingIsLearnedOfACameraThatDoesNotErr) {
  EXPECT_LT(rms_left(after_a_drive(corridor(), nothing), nothing), 0.0012);
}

// Cupboards whose fronts stand two and three centimetres before the walls.
TEST(RangeError, WhatStandsBeforeAWallIsNoErrorOfTheCamera) {
  testing_scene::Scene scene = corridor();
  using Point = Eigen::Vector3d;
  scene.boxes = {{Point(1.5, 1.08, 0), Point(2.6, 1.2, 2)},
                 {Point(3.2, 1.07, 0), Point(4.2, 1.2, 1.2)},
                 {Point(2.5, -1, 0), Point(3.5, -0.87, 2)}};
  EXPECT_LT(rms_left(after_a_drive(scene, wiggle), wiggle), 0.002);
}

// A carpet of 1 cm lies across the way: its edges are a step at other ranges in every image, the wiggle is
// not.
TEST(RangeError, ACarpetTeachesNoErrorAndTheWiggleIsLearnedBesideIt) {
  using Point = Eigen::Vector3d;
  testing_scene::Scene scene = corridor();
  scene.boxes = {{Point(1.9, -0.9, 0), Point(3.9, 1.1, 0.01)}};
  EXPECT_LT(rms_left(after_a_drive(scene, wiggle), wiggle), 0.0015);
  EXPECT_LT(rms_left(after_a_drive(scene, nothing), nothing), 0.0007);  // 0.0008 without cuts
}

// The floor alone: nothing else tells that what stands out is no error of the camera.
TEST(RangeError, AStepOfTheFloorIsToldFromTheWiggleWithoutWalls) {
  using Point = Eigen::Vector3d;
  testing_scene::Scene scene;
  scene.planes = {{{0, 0, 1}, 0}};
  scene.boxes = {{Point(1.9, -9, 0), Point(3.9, 9, 0.01)}};
  EXPECT_LT(rms_left(after_a_drive(scene, wiggle), wiggle), 0.002);
}

// Errors as the prior has them: what is left of them is as large as sigma says.
TEST(RangeError, SigmaIsWhatIsLeft) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed, 5);
    const double sine = random.normal(0, 0.0042), cosine = random.normal(0, 0.0042),
                 wave_length = random.uniform(1.5, 4);
    const Wave wave = [&](double range) {
      const double phase = 2 * M_PI * range / wave_length;
      return sine * std::sin(phase) + cosine * std::cos(phase);
    };
    const RangeError error = after_a_drive(corridor(), wave, seed);
    for (double range = 1.5; range < 4.5; range += 0.5, ++count)
      sum += std::pow((error.at(range) - wave(range)) / error.sigma(range), 2);
  }
  EXPECT_GT(sum / count, 0.1);
  EXPECT_LT(sum / count, 1.5);
}

// Of what is stated the wiggle is a part: what is learned of it is gone, what is not stays.
TEST(RangeError, WhatRemainsIsLessThanStatedWhereItHasLearned) {
  const double constant = tof_camera().depth_noise.constant, rest = 0.0027, stated = constant + rest;
  const RangeError fresh(tof_camera(), {}), learned = after_a_drive(corridor(), wiggle);
  EXPECT_NEAR(fresh.remaining(stated, 2.5), stated, 1e-9);
  for (const double range : {2.0, 3.0, 4.0}) {
    EXPECT_GE(learned.remaining(stated, range), rest + learned.sigma(range) - 1e-12) << range;
    EXPECT_LT(learned.remaining(stated, range), rest + 0.7 * constant) << range;
  }
}

// What is no error by range is noise, and stays as it is stated.
TEST(RangeError, NoiseThatNobodyLearnsRemains) {
  const RangeError learned = after_a_drive(corridor(), nothing);
  EXPECT_GT(learned.remaining(0.007, 3), 0.9 * 0.007);
}

TEST(RangeError, WhatIsKnownIsTakenAwayAndNothingStaysNothing) {
  const RgbdCalibration calibration = tof_camera();
  const RangeError error = after_a_drive(corridor(), wiggle);
  Random random(3), same(3);
  const Eigen::Isometry3d T = view(0.4, 0.1, 0.3);
  cv::Mat seen = measured(corridor(), calibration, T, wiggle, random);
  const cv::Mat raw = seen.clone(), exact = measured(corridor(), calibration, T, nothing, same);
  error.correct(seen);
  double before = 0, after = 0;
  for (int v = 0; v < seen.rows; ++v)
    for (int u = 0; u < seen.cols; ++u) {
      const auto at = [&](const cv::Mat& image) {
        return static_cast<double>(image.at<std::uint16_t>(v, u));
      };
      EXPECT_EQ(at(raw) == 0, at(seen) == 0);
      if (at(raw) == 0 || at(exact) == 0 || at(exact) > 4500) continue;
      before += std::pow(at(raw) - at(exact), 2);
      after += std::pow(at(seen) - at(exact), 2);
    }
  EXPECT_LT(after, 0.15 * before);
}

TEST(RangeError, WhoeverIsToldNotToLearnLeavesImagesAlone) {
  RangeErrorSettings off;
  off.enabled = false;
  const RangeError error = after_a_drive(corridor(), wiggle, 1, tof_camera(), off);
  Random random(4);
  cv::Mat seen = measured(corridor(), tof_camera(), view(0, 0, 0), wiggle, random);
  const cv::Mat raw = seen.clone();
  error.correct(seen);
  EXPECT_EQ(cv::countNonZero(seen != raw), 0);
}

}  // namespace
}  // namespace lcmslam
