// Folders of each layout, written by the test.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include "tests/unit/datasets/scratch_folder.hpp"

namespace lcmslam {
namespace {

using namespace testing_files;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

std::string number(int n, int digits) {
  const std::string text = std::to_string(n);
  return std::string(static_cast<std::size_t>(digits) - text.size(), '0') + text;
}

void write_seven_scenes(const ScratchFolder& folder, const std::string& sequence, int count,
                        const char* colour) {
  for (int i = 0; i < count; ++i) {
    const std::string frame = sequence + "frame-" + number(i, 6);
    folder.write(frame + ".color." + colour, colour_image(i));
    folder.write(frame + ".depth.png", depth_image(1000 + i));
    folder.write(frame + ".pose.txt", "0 -1 0 " + std::to_string(i) + "\n1 0 0 2\n0 0 1 3\t\r\n0 0 0 1\n");
  }
}

TEST(SevenScenes, OneSequence) {
  const ScratchFolder folder;
  write_seven_scenes(folder, "", 4, "png");
  folder.write("calibration.yaml", calibration_text());
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 4u);
  EXPECT_THAT(source->problems(), IsEmpty());
  EXPECT_THAT(source->notes(), Contains("no stamps: 30 Hz assumed"));
  EXPECT_EQ(source->entry(3).utime - source->entry(0).utime, 100'000);

  const auto frame = source->frame(2);
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(frame->seq, 2);
  EXPECT_EQ(frame->sensor, "small");
  EXPECT_EQ(frame->utime, source->entry(2).utime);
  const RgbdFrame decoded = decode(*frame);
  EXPECT_EQ(decoded.depth.at<std::uint16_t>(5, 7), 1014);
  EXPECT_EQ(decoded.depth.at<std::uint16_t>(0, 0), 0);
  EXPECT_EQ(decoded.depth.at<std::uint16_t>(0, 1), 0);  // 65535
  EXPECT_LT(cv::norm(decoded.colour, colour_image(2), cv::NORM_L1) / (3 * width * height), 8);

  ASSERT_EQ(source->truth().size(), 4u);
  EXPECT_EQ(source->truth()[2].utime, frame->utime);
  EXPECT_TRUE(source->truth()[2].T_world_body.translation().isApprox(Eigen::Vector3d(2, 2, 3)));
  EXPECT_NEAR(yaw(source->truth()[2].T_world_body), M_PI / 2, 1e-12);
}

TEST(SevenScenes, ParentOfSequences) {
  const ScratchFolder folder;
  write_seven_scenes(folder, "seq-02/", 2, "jpg");
  write_seven_scenes(folder, "seq-01/", 3, "jpg");
  folder.write("calibration.yaml", calibration_text());
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 5u);
  EXPECT_EQ(source->entry(3).utime - source->entry(2).utime, 1'000'000);
  EXPECT_THAT(source->notes(), Contains(HasSubstr("seq-02 begins at frame 3")));
  EXPECT_EQ(decode(*source->frame(3)).depth.at<std::uint16_t>(1, 1), 1002);
}

TEST(SevenScenes, RateAndBodyOfTheTruthByLcmslamYaml) {
  const ScratchFolder folder;
  write_seven_scenes(folder, "", 3, "png");
  folder.write("head.yaml",
               "colour: {width: 32, height: 24, fx: 30, fy: 30, cx: 15.5, cy: 11.5}\n"
               "depth: {width: 32, height: 24, fx: 28, fy: 28, cx: 15.5, cy: 11.5}\n"
               "colour_depth: {translation: [-0.5, 0, 0], quaternion: [1, 0, 0, 0]}\n");
  folder.write("lcmslam.yaml",
               "format: seven_scenes\nframe_rate: 10\ntruth_of: depth\ncalibration: head.yaml\n");
  const auto source = open_dataset(folder.path());
  EXPECT_EQ(source->entry(1).utime - source->entry(0).utime, 100'000);
  EXPECT_EQ(source->truth_frame(), "camera");
  // The colour camera stands half a metre right of the depth camera, along world y after the turn.
  EXPECT_TRUE(source->truth()[1].T_world_body.translation().isApprox(Eigen::Vector3d(1, 2.5, 3)));
}

void write_tum(const ScratchFolder& folder, const std::string& header = "") {
  std::string rgb = header;
  std::string depth;
  std::string truth = "# timestamp tx ty tz qx qy qz qw\n";
  for (int i = 0; i < 5; ++i) {
    const std::string second = "100.0" + std::to_string(i);
    rgb += second + "0000 rgb/" + std::to_string(i) + ".png\n";
    depth += second + "4000 depth/" + std::to_string(i) + ".png\n";
    truth += second + " 1 2 " + std::to_string(i) + " 0 0 0 1\n";
    folder.write("rgb/" + std::to_string(i) + ".png", colour_image(i));
    folder.write("depth/" + std::to_string(i) + ".png", depth_image(5000));
  }
  folder.write("rgb.txt", rgb);
  folder.write("depth.txt", depth);
  folder.write("groundtruth.txt", truth);
}

TEST(Tum, PairsByNearestStamp) {
  const ScratchFolder folder;
  write_tum(folder);
  folder.write("calibration.yaml", calibration_text());
  // One colour image has no partner within 20 ms.
  folder.write("rgb.txt", folder.read("rgb.txt") + "100.500000 rgb/4.png\n");
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(source->entry(i).utime, 100'000'000 + static_cast<Utime>(i) * 10'000);
    EXPECT_EQ(source->entry(i).depth_utime, source->entry(i).utime + 4'000);
  }
  EXPECT_THAT(source->notes(), Contains(HasSubstr("1 of 6 colour images")));
  EXPECT_EQ(decode(*source->frame(0)).depth.at<std::uint16_t>(10, 15), 1005);  // (5000 + 25) / 5
  EXPECT_EQ(source->truth().size(), 5u);
}

// The third depth image is nearest to two colour images: the nearer one gets it.
TEST(Tum, AssociationIsOneToOne) {
  const ScratchFolder folder;
  write_tum(folder);
  folder.write("calibration.yaml", calibration_text());
  folder.write("rgb.txt", "1.000 rgb/0.png\n1.010 rgb/1.png\n");
  folder.write("depth.txt", "1.007 depth/0.png\n");
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 1u);
  EXPECT_EQ(source->entry(0).utime, 1'010'000);
}

// The clock decides which images belong together, not the stamps.
TEST(Tum, PairsByTheDepthClockOfItsCalibration) {
  const ScratchFolder folder;
  write_tum(folder);
  folder.write("calibration.yaml", std::string(calibration_text()) + "depth_clock_offset: -0.014\n");
  folder.write("rgb.txt", "1.000 rgb/0.png\n1.010 rgb/1.png\n1.500 rgb/2.png\n1.600 rgb/3.png\n");
  // Of 0.998, of 1.012, of 1.475 (which none is near), of 1.602.
  folder.write("depth.txt", "1.012 depth/0.png\n1.026 depth/1.png\n1.489 depth/2.png\n1.616 depth/3.png\n");
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 3u);
  EXPECT_EQ(source->entry(0).depth_utime, 1'012'000);
  EXPECT_EQ(source->entry(1).depth_utime, 1'026'000);
  EXPECT_EQ(source->entry(2).depth_utime, 1'616'000);
}

TEST(Tum, IntrinsicsByTheSequencesNameOrTheDefault) {
  const ScratchFolder named;
  write_tum(named, "# color images\n# file: 'rgbd_dataset_freiburg2_desk.bag'\n");
  EXPECT_EQ(open_dataset(named.path())->calibration().sensor, "tum_fr2");
  const ScratchFolder nameless;
  write_tum(nameless);
  const auto source = open_dataset(nameless.path());
  EXPECT_EQ(source->calibration().colour.fx, 525);
  EXPECT_THAT(source->notes(), Contains(HasSubstr("tum_default.yaml assumed")));
  nameless.write("mine.yaml", calibration_text());
  DatasetOptions options;
  options.calibration = nameless / "mine.yaml";
  EXPECT_EQ(open_dataset(nameless.path(), options)->calibration().sensor, "small");
}

// ICL-NUIM counts frames instead of giving seconds, and names the depth image first.
TEST(Tum, IclNuim) {
  const ScratchFolder folder;
  std::string associations;
  std::string truth;
  for (int i = 1; i <= 4; ++i) {
    const std::string n = std::to_string(i);
    associations.append(n).append(" depth/").append(n).append(".png ");
    associations.append(n).append(" rgb/").append(n).append(".png\n");
    truth.append(n).append(" 0 0 ").append(n).append(" 0 0 0 1\n");
    folder.write("rgb/" + n + ".png", colour_image(i));
    folder.write("depth/" + n + ".png", depth_image(5000));
  }
  folder.write("associations.txt", associations);
  folder.write("livingRoom1.gt.freiburg", truth);
  folder.write("calibration.yaml", calibration_text());
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 4u);
  EXPECT_EQ(source->entry(3).utime - source->entry(0).utime, 100'000);
  EXPECT_THAT(source->notes(), Contains(HasSubstr("30 Hz assumed")));
  ASSERT_EQ(source->truth().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(source->truth()[i].utime, source->entry(i).utime);
    EXPECT_TRUE(source->frame(i).has_value());
  }
}

TEST(Numbered, StampsMatricesAndGaps) {
  const ScratchFolder folder;
  for (int i : {7, 8, 10}) {  // 9 was lost
    folder.write("left" + number(i, 3) + ".png", colour_image(i));
    folder.write("range" + std::to_string(i) + ".pgm", depth_image(2000));
  }
  folder.write("left" + number(12, 3) + ".png", colour_image(1));  // without depth
  folder.write("times.txt", "5.0\n5.1\n5.2\n5.3\n5.4\n5.5\n");
  std::string poses;
  for (int i = 0; i < 4; ++i) poses += "1 0 0 " + std::to_string(i) + " 0 1 0 0 0 0 1 0\n";
  folder.write("poses.txt", poses);
  folder.write("calibration.yaml", calibration_text());
  folder.write("lcmslam.yaml",
               "format: numbered\ncolour: left%03d.png\ndepth: range%d.pgm\ndepth_scale: 2000\n"
               "stamps: times.txt\ntruth_of: robot\nposes: {file: poses.txt, format: matrices}\n");
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 3u);
  EXPECT_EQ(source->entry(1).utime, 5'100'000);
  EXPECT_EQ(source->entry(2).utime, 5'300'000);
  EXPECT_EQ(source->truth_frame(), "robot");
  ASSERT_EQ(source->truth().size(), 4u);
  EXPECT_EQ(source->truth()[3].utime, 5'300'000);
  EXPECT_EQ(source->truth()[3].T_world_body.translation().x(), 3);
  EXPECT_EQ(decode(*source->frame(2)).depth.at<std::uint16_t>(0, 2), 1001);
  ASSERT_EQ(source->problems().size(), 1u);
  EXPECT_THAT(source->problems()[0], HasSubstr("range12.pgm: is missing"));
}

// Each camera has seen its image at a time of its own.
TEST(Numbered, StampsOfBothCameras) {
  const ScratchFolder folder;
  for (int i : {0, 1}) {
    folder.write("rgb" + std::to_string(i) + ".png", colour_image(i));
    folder.write("depth" + std::to_string(i) + ".png", depth_image(1000));
  }
  folder.write("times.txt", "5.0 5.0064\n5.1 5.0976\n");
  folder.write("calibration.yaml", calibration_text());
  folder.write("lcmslam.yaml",
               "format: numbered\ncolour: rgb%d.png\ndepth: depth%d.png\nstamps: times.txt\n");
  const auto source = open_dataset(folder.path());
  ASSERT_EQ(source->size(), 2U);
  EXPECT_EQ(source->entry(0).utime, 5'000'000);
  EXPECT_EQ(source->frame(0)->depth.utime, 5'006'400);
  EXPECT_EQ(source->frame(1)->depth.utime, 5'097'600);
  folder.write("times.txt", "5.0 soon\n5.1 5.0976\n");
  EXPECT_THROW(open_dataset(folder.path()), DatasetError);
}

TEST(Numbered, DescriptionByOption) {
  const ScratchFolder folder;
  const ScratchFolder elsewhere;
  folder.write("a/0.png", colour_image(0));
  folder.write("b/0.png", depth_image(1000));
  elsewhere.write("camera.yaml", calibration_text());
  elsewhere.write("set.yaml",
                  "format: numbered\ncolour: a/%d.png\ndepth: b/%d.png\ncalibration: camera.yaml\n");
  EXPECT_THROW(open_dataset(folder.path()), DatasetError);
  DatasetOptions options;
  options.description = elsewhere / "set.yaml";
  const auto source = open_dataset(folder.path(), options);
  EXPECT_EQ(source->size(), 1u);
  EXPECT_EQ(source->calibration().sensor, "small");
  EXPECT_THAT(source->notes(), Contains("no true poses"));
}

}  // namespace
}  // namespace lcmslam
