#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/calibration_text.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

using testing::HasSubstr;

RgbdCalibration parse(const std::string& text) {
  const ConfigNode config = ConfigNode::parse(text, "head.yaml");
  RgbdCalibration calibration = read_calibration(config);
  config.finish();
  return calibration;
}

std::string error_of(const std::string& text) {
  try {
    parse(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

const std::string colour = "colour: {width: 640, height: 480, fx: 554, fy: 555, cx: 319.5, cy: 239.5}\n";
const std::string tof =
    colour +
    "depth: {width: 176, height: 144, fx: 200, fy: 200, cx: 87.5, cy: 71.5, distortion: [0.1, 0, 0, 0]}\n"
    "colour_depth: {translation: [0.08, 0, 0.01], quaternion: [1, 0, 0, 0]}\n";

TEST(Calibration, EveryShippedFileLoads) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() / "config/calibration")) {
    if (entry.path().extension() != ".yaml") continue;
    const RgbdCalibration calibration = load_calibration(entry.path());
    EXPECT_FALSE(calibration.sensor.empty()) << entry.path();
    EXPECT_GT(calibration.colour.width, 0) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 6);
}

TEST(Calibration, WhatIsWrittenIsReadAgain) {
  RgbdCalibration c = parse(tof + "mount: {translation: [0.1, 0.02, 1.3], rpy: [0.01, 0.349, -0.02]}\n" +
                            "depth_error: {offset: 0.01, scale: 0.001, wiggle: 0.006, period: 1.9, phase: "
                            "-0.4, tilt_x: 0.01, tilt_y: "
                            "-0.002}\n"
                            "depth_clock_offset: -0.0142\nrolling_shutter: 0.03\nsensor: 'head: \"1\"'\n");
  c.colour.distortion = {0.1 / 3, -0.2, 0.001, 0.002, 0.3};
  c.colour.fx = 1000.0 / 3;
  const RgbdCalibration back = parse(calibration_text(c, "two\nlines"));
  EXPECT_EQ(back.sensor, c.sensor);
  EXPECT_TRUE(back.colour == c.colour) << "every bit of it";
  EXPECT_TRUE(back.depth == c.depth);
  EXPECT_TRUE(back.T_colour_depth.isApprox(c.T_colour_depth, 1e-12));
  EXPECT_TRUE(back.has_mount);
  EXPECT_TRUE(back.T_robot_camera.isApprox(c.T_robot_camera, 1e-12));
  EXPECT_EQ(back.depth_clock_offset, c.depth_clock_offset);
  EXPECT_EQ(back.rolling_shutter, c.rolling_shutter);
  EXPECT_TRUE(back.depth_error == c.depth_error);
  EXPECT_EQ(back.depth_error.phase, -0.4);
  EXPECT_EQ(back.depth_error.tilt_x, 0.01);
  EXPECT_EQ(back.depth_error.tilt_y, -0.002);
  EXPECT_EQ(back.depth_noise.constant, c.depth_noise.constant);
  EXPECT_EQ(back.depth_max, c.depth_max);
  EXPECT_EQ(back.pixel_sigma, c.pixel_sigma);
  const RgbdCalibration registered = parse(calibration_text(parse(colour + "depth_registered: true\n")));
  EXPECT_TRUE(registered.depth_registered);
}

TEST(Calibration, ADepthErrorThatCannotBeUndoneIsRefused) {
  EXPECT_THAT(error_of(tof + "depth_error: {wiggle: 0.5, period: 1}\n"), HasSubstr("depth_error.wiggle"));
}

// Kinects of the first kind and Xtions read their rows one after the other.
TEST(Calibration, IsFoundByTheSensorsName) {
  const std::filesystem::path folder = source_folder() / "config/calibration";
  for (const char* name : {"tum_default", "tum_fr1", "tum_fr2", "tum_fr3", "seven_scenes"}) {
    const auto found = find_calibration(name, folder);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->sensor, name);
    EXPECT_EQ(found->rolling_shutter, 0.03) << name;
  }
  EXPECT_EQ(find_calibration("icl_nuim", folder)->rolling_shutter, 0) << "rendered";
  for (const char* name : {"", "nobody", "../calibration/tum_fr1", "tum_fr1.yaml", "a b"})
    EXPECT_FALSE(find_calibration(name, folder)) << name;
}

TEST(Calibration, ReadoutIsCheckedWhereItStands) {
  EXPECT_EQ(parse(tof + "rolling_shutter: 0.02\n").rolling_shutter, 0.02);
  EXPECT_EQ(parse(tof).rolling_shutter, 0);
  EXPECT_THAT(error_of(tof + "rolling_shutter: 0.5\n"), HasSubstr("rolling_shutter"));
  RgbdCalibration calibration = parse(tof);
  calibration.rolling_shutter = -0.01;
  EXPECT_THROW(calibration.check(), std::invalid_argument);
}

TEST(Calibration, RegisteredHeadTakesTheColourCamerasGeometry) {
  const RgbdCalibration calibration = parse("sensor: kinect\n" + colour + "depth_registered: true\n");
  EXPECT_EQ(calibration.sensor, "kinect");
  EXPECT_TRUE(calibration.depth_registered);
  EXPECT_EQ(calibration.depth.width, 640);
  EXPECT_EQ(calibration.depth.fy, 555);
  EXPECT_FALSE(calibration.has_mount);
  EXPECT_TRUE(calibration.T_robot_camera.isApprox(optical_axes()));
}

TEST(Calibration, HeadOfTwoCameras) {
  const RgbdCalibration calibration = parse(tof +
                                            "depth_clock_offset: -0.012\n"
                                            "depth_noise: {constant: 0.002, amplitude: 0.001}\n"
                                            "depth_min: 0.2\ndepth_max: 7.5\npixel_sigma: 0.7\n");
  EXPECT_EQ(calibration.depth.width, 176);
  EXPECT_EQ(calibration.depth.distortion.size(), 4u);
  EXPECT_TRUE(calibration.T_colour_depth.translation().isApprox(Eigen::Vector3d(0.08, 0, 0.01)));
  EXPECT_EQ(calibration.depth_time(1'000'000), 988'000);
  EXPECT_EQ(calibration.depth_noise.constant, 0.002);
  EXPECT_EQ(calibration.depth_noise.amplitude, 0.001);
  EXPECT_EQ(calibration.depth_max, 7.5);
  EXPECT_EQ(calibration.pixel_sigma, 0.7);
}

// Positive pitch looks down: the optical axis of a head inclined by 30 degrees meets the ground.
TEST(Calibration, MountByAngles) {
  const RgbdCalibration calibration =
      parse(tof + "mount: {translation: [0.1, 0.2, 1.3], rpy: [0, 0.5235987755982988, 0]}\n");
  ASSERT_TRUE(calibration.has_mount);
  const Eigen::Vector3d axis = calibration.T_robot_camera.linear() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(axis.x(), std::sqrt(3) / 2, 1e-12);
  EXPECT_NEAR(axis.z(), -0.5, 1e-12);
  EXPECT_TRUE(calibration.T_robot_camera.translation().isApprox(Eigen::Vector3d(0.1, 0.2, 1.3)));
}

TEST(Calibration, MountByQuaternionIsTheCamerasRotation) {
  // The permutation of axes itself: half a turn of three axes.
  const RgbdCalibration calibration =
      parse(tof + "mount: {translation: [0, 0, 0], quaternion: [0.5, -0.5, 0.5, -0.5]}\n");
  EXPECT_TRUE(calibration.T_robot_camera.isApprox(optical_axes(), 1e-12));
}

TEST(Calibration, ErrorsNameFileLineAndKey) {
  EXPECT_THAT(error_of(tof + "depth_nois: {constant: 1}\n"),
              testing::AllOf(HasSubstr("head.yaml:4"), HasSubstr("depth_nois")));
  EXPECT_THAT(error_of("sensor: x\n"), HasSubstr("colour"));
  EXPECT_THAT(error_of(colour), HasSubstr("depth_registered: true"));
  EXPECT_THAT(error_of(tof + "depth_registered: true\n"), HasSubstr("must be left out"));
  EXPECT_THAT(error_of(tof + "depth_max: 0.1\n"), HasSubstr("depth_max"));
  EXPECT_THAT(error_of(tof + "mount: {translation: [0, 0], rpy: [0, 0, 0]}\n"), HasSubstr("translation"));
  EXPECT_THAT(error_of(tof + "mount: {translation: [0, 0, 1.2], rpy: [180, 0, 0]}\n"),
              HasSubstr("180 degrees are 3.14159"));
  EXPECT_THAT(error_of(tof + "mount: {translation: [0, 0, 1200], rpy: [0, 0, 0]}\n"),
              HasSubstr("1200 mm are 1.2"));
  EXPECT_THAT(error_of(tof + "mount: {translation: [0, 0, 0], quaternion: [1, 1, 0, 0]}\n"),
              HasSubstr("unit quaternion"));
  EXPECT_THAT(error_of(colour + "depth_registered: true\npixel_sigma: 0\n"), HasSubstr("pixel_sigma"));
  EXPECT_THAT(error_of("colour: {width: 640, height: 480, fx: 1, fy: 1, cx: 0, cy: 0, "
                       "distortion: [1, 2, 3]}\ndepth_registered: true\n"),
              HasSubstr("distortion"));
}

TEST(DepthNoise, GrowsWithDistanceAndFallsWithAmplitude) {
  DepthNoise noise;
  EXPECT_NEAR(noise.sigma(2.4), 0.0012 + 0.0019 * 4, 1e-12);
  noise = {0.001, 0, 0, 0.001};
  EXPECT_NEAR(noise.sigma(2, 1), 0.001 + 0.004, 1e-12);
  EXPECT_NEAR(noise.sigma(2, 0.25), 0.001 + 0.008, 1e-12);
  EXPECT_TRUE(std::isfinite(noise.sigma(2, 0)));  // a black pixel
}

}  // namespace
}  // namespace lcmslam
