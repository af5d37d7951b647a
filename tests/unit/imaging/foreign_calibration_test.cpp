// Intrinsics as ROS and OpenCV write them, alone and named by a calibration of ours.

#include <lcmslam/imaging/io/foreign_calibration.hpp>

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <opencv2/core/persistence.hpp>

#include <lcmslam/imaging/io/calibration_file.hpp>

namespace lcmslam {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string ros =
    "image_width: 640\n"
    "image_height: 480\n"
    "camera_name: head_rgb\n"
    "camera_matrix:\n"
    "  rows: 3\n"
    "  cols: 3\n"
    "  data: [525.5, 0.0, 319.25, 0.0, 526.75, 239.5, 0.0, 0.0, 1.0]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients:\n"
    "  rows: 1\n"
    "  cols: 5\n"
    "  data: [0.25, -0.75, -0.002, 0.001, 0.5]\n"
    "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
    "projection_matrix: {rows: 3, cols: 4, data: [540, 0, 318, 0, 0, 541, 238, 0, 0, 0, 1, 0]}\n";

class ForeignCalibration : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcmslam-calibration-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string error_of(const std::string& text) const {
    try {
      load_calibration(write("camera.yaml", text));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  std::filesystem::path folder_;
};

void expect_the_camera(const CameraModel& camera) {
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fx, 525.5);
  EXPECT_EQ(camera.fy, 526.75);
  EXPECT_EQ(camera.cx, 319.25);
  EXPECT_EQ(camera.cy, 239.5);
  EXPECT_THAT(camera.distortion, ElementsAre(0.25, -0.75, -0.002, 0.001, 0.5));
}

TEST_F(ForeignCalibration, RosCameraInfoIsAHeadWithRegisteredDepth) {
  const RgbdCalibration calibration = load_calibration(write("camera.yaml", ros));
  EXPECT_EQ(calibration.sensor, "head_rgb");
  expect_the_camera(calibration.colour);
  EXPECT_TRUE(calibration.depth_registered);
  expect_the_camera(calibration.depth);
  EXPECT_FALSE(calibration.has_mount);
  EXPECT_EQ(describe(calibration),
            "sensor head_rgb, colour 640x480, depth registered to it, hand-held (no mount)");
}

TEST_F(ForeignCalibration, RosMessagePrintedAsYaml) {
  for (const bool ros2 : {false, true}) {
    std::string text =
        "header: {seq: 3, stamp: {secs: 1, nsecs: 2}, frame_id: rgb}\n"
        "height: 480\nwidth: 640\ndistortion_model: \"plumb_bob\"\n"
        "D: [0.25, -0.75, -0.002, 0.001, 0.5]\n"
        "K: [525.5, 0.0, 319.25, 0.0, 526.75, 239.5, 0.0, 0.0, 1.0]\n"
        "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
    if (ros2) text = changed(changed(text, "D:", "d:"), "K:", "k:");
    expect_the_camera(load_calibration(write("camera.yaml", text)).colour);
  }
}

TEST_F(ForeignCalibration, WhatOpenCvWritesItself) {
  const std::string file = folder_ / "camera.yml";
  {
    cv::FileStorage storage(file, cv::FileStorage::WRITE);
    storage << "calibration_time"
            << "Sun 22 Nov 2026 07:00:00 PM UTC"
            << "image_width" << 640 << "image_height" << 480 << "flags" << 0;
    storage << "camera_matrix"
            << cv::Mat((cv::Mat_<double>(3, 3) << 525.5, 0, 319.25, 0, 526.75, 239.5, 0, 0, 1));
    storage << "distortion_coefficients"
            << cv::Mat((cv::Mat_<double>(5, 1) << 0.25, -0.75, -0.002, 0.001, 0.5));
    storage << "avg_reprojection_error" << 0.21;
  }
  const RgbdCalibration calibration = load_calibration(file);
  expect_the_camera(calibration.colour);
  EXPECT_EQ(calibration.sensor, "rgbd");
}

TEST_F(ForeignCalibration, CoefficientsOfZeroAreAnIdealImage) {
  EXPECT_THAT(
      load_calibration(write("a.yaml", changed(ros, "[0.25, -0.75, -0.002, 0.001, 0.5]", "[0, 0, 0, 0, 0]")))
          .colour.distortion,
      IsEmpty());
  const std::string long_one = changed(ros, "0.001, 0.5]", "0.001, 0.5, 0.1, 0, 0, 0, 0, 0, 0, 0, 0]");
  EXPECT_THAT(load_calibration(write("b.yaml", long_one)).colour.distortion,
              ElementsAre(0.25, -0.75, -0.002, 0.001, 0.5, 0.1, 0, 0));
}

TEST_F(ForeignCalibration, OurFileNamesThemForBothCameras) {
  write("rgb.yaml", ros);
  write("depth.yaml", changed(changed(ros, "640", "320"), "480", "240"));
  const RgbdCalibration head =
      load_calibration(write("head.yaml",
                             "sensor: mine\ncolour: {file: rgb.yaml}\ndepth: {file: depth.yaml}\n"
                             "colour_depth: {translation: [0.025, 0, 0], quaternion: [1, 0, 0, 0]}\n"
                             "mount: {translation: [0.1, 0, 1.2], rpy: [0, 0.3, 0]}\n"));
  EXPECT_EQ(head.sensor, "mine");
  expect_the_camera(head.colour);
  EXPECT_EQ(head.depth.width, 320);
  EXPECT_FALSE(head.depth_registered);
  EXPECT_NEAR(head.T_colour_depth.translation().x(), 0.025, 1e-12);
  EXPECT_TRUE(head.has_mount);
  EXPECT_THAT(error_of("colour: {file: none.yaml}\ndepth_registered: true\n"),
              AllOf(HasSubstr("camera.yaml:1"), HasSubstr("none.yaml is not there")));
  write("other.yaml", "speed: 3\n");
  EXPECT_THAT(error_of("colour: {file: other.yaml}\ndepth_registered: true\n"),
              AllOf(HasSubstr("camera.yaml:1"), HasSubstr("other.yaml has no camera_matrix")));
}

TEST_F(ForeignCalibration, ErrorsNameFileKeyAndWhatWouldBeRight) {
  EXPECT_THAT(error_of(changed(ros, "image_width: 640\n", "")),
              AllOf(HasSubstr("camera.yaml"), HasSubstr("image_width is missing"), HasSubstr("pixels")));
  EXPECT_THAT(
      error_of(changed(ros, "plumb_bob", "equidistant")),
      AllOf(HasSubstr("camera.yaml:8"), HasSubstr("'equidistant'"), HasSubstr("rational_polynomial")));
  EXPECT_THAT(error_of(changed(ros, "distortion_model: plumb_bob", "fisheye_model: 1")),
              AllOf(HasSubstr("camera.yaml:8"), HasSubstr("fisheye_model"), HasSubstr("must be 0")));
  EXPECT_EQ(error_of(changed(ros, "distortion_model: plumb_bob", "fisheye_model: 0")), "");
  EXPECT_THAT(error_of(changed(ros, "525.5, 0.0, 319.25", "525.5, 319.25")),
              AllOf(HasSubstr("camera.yaml:4"), HasSubstr("fx, 0, cx")));
  EXPECT_THAT(error_of(changed(ros, "525.5, 0.0,", "525.5, 8.0,")), HasSubstr("skewed"));
  EXPECT_THAT(error_of(changed(ros, "[525.5", "[-525.5")), HasSubstr("above 0"));
  EXPECT_THAT(error_of(changed(ros, "0.001, 0.5]", "0.001, 0.5, 0, 0, 0, 0.2]")),
              AllOf(HasSubstr("camera.yaml:9"), HasSubstr("9 coefficients"), HasSubstr("4, 5 or 8")));
  EXPECT_THAT(error_of("colours: 3\n"), AllOf(HasSubstr("colour is missing"), HasSubstr("camera_matrix")));
  EXPECT_THAT(error_of(changed(ros, "640", "wide")),
              AllOf(HasSubstr("camera.yaml:1"), HasSubstr("image_width")));
}

}  // namespace
}  // namespace lcmslam
