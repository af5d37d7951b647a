// Video files and image sequences that the test writes, read as a camera.

#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <fstream>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "procs/camera/drivers/open_driver.hpp"
#include "tests/support/written_head.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using testing::largest_difference;
using testing::numbered_colour;
using testing::numbered_depth;

const cv::Size size{160, 120};

class VideoFiles : public ::testing::Test {
 protected:
  std::vector<CameraShot> read_all(const VideoSettings& settings) {
    const auto camera = open_video(settings);
    std::vector<CameraShot> frames;
    while (auto frame = camera->read(std::chrono::milliseconds(100))) frames.push_back(std::move(*frame));
    EXPECT_TRUE(camera->ended());
    return frames;
  }
  void write_sequence(int images, bool depth) {
    for (int i = 0; i < images; ++i) {
      char name[32];
      std::snprintf(name, sizeof name, "%04d.png", i);
      cv::imwrite((folder / name).string(), depth ? numbered_depth(size, i) : numbered_colour(size, i));
    }
  }
  std::string refusal(const VideoSettings& settings) {
    try {
      read_all(settings);
    } catch (const CameraError& error) {
      return error.what();
    }
    return "";
  }

  testing::TemporaryFolder folder;
};

TEST_F(VideoFiles, AreReadImageByImageWithTheirStamps) {
  const std::string file = (folder / "drive.avi").string();
  cv::VideoWriter writer(file, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, size);
  ASSERT_TRUE(writer.isOpened());
  for (int i = 0; i < 30; ++i) writer.write(numbered_colour(size, i));
  writer.release();
  VideoSettings settings;
  settings.file = file;
  settings.start = 1000;
  const auto frames = read_all(settings);
  ASSERT_EQ(frames.size(), 30U);
  for (int i = 0; i < 30; ++i) {
    const CameraShot& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.utime, 1'000'000'000 + i * 40'000) << i;
    EXPECT_LT(largest_difference(cv::imdecode(frame.jpeg, cv::IMREAD_COLOR), numbered_colour(size, i)), 12)
        << i;
    EXPECT_EQ(frame.jpeg_size, size);
    EXPECT_TRUE(frame.colour.empty());
    EXPECT_TRUE(frame.depth.empty());
  }
  // The bytes are the file's own.
  std::ifstream in(file, std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(in)), {});
  for (const CameraShot& frame : frames)
    EXPECT_NE(all.find(std::string(frame.jpeg.begin(), frame.jpeg.end())), std::string::npos);

  settings.keep_jpeg = false;
  const auto decoded = read_all(settings);
  ASSERT_EQ(decoded.size(), 30U);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(decoded[i].utime, frames[i].utime);
    EXPECT_TRUE(decoded[i].jpeg.empty());
    EXPECT_EQ(largest_difference(decoded[i].colour, cv::imdecode(frames[i].jpeg, cv::IMREAD_COLOR)) < 8,
              true);
  }
}

TEST_F(VideoFiles, SequencesOfImagesAreReadBitForBit) {
  write_sequence(12, false);
  VideoSettings settings;
  settings.file = (folder / "%04d.png").string();
  settings.rate = 20;
  settings.start = 7;
  const auto frames = read_all(settings);
  ASSERT_EQ(frames.size(), 12U);
  for (int i = 0; i < 12; ++i) {
    const CameraShot& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(largest_difference(frame.colour, numbered_colour(size, i)), 0) << i;
    EXPECT_EQ(frame.utime, 7'000'000 + i * 50'000);
  }
}

/// What goes to the log while it lives.
class HeardLog {
 public:
  HeardLog() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("heard", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~HeardLog() { spdlog::set_default_logger(before_); }
  std::string text() const { return text_.str(); }

 private:
  std::shared_ptr<spdlog::logger> before_;
  std::ostringstream text_;
};

TEST_F(VideoFiles, ASequenceGoesOnAfterWhatIsMissingAndSaysSoOnce) {
  write_sequence(20, false);
  for (const char* name : {"0000.png", "0007.png", "0012.png", "0013.png"})
    std::filesystem::remove(folder / name);
  for (const char* name : {"0015.png", "0017.png"}) std::ofstream(folder / name) << "no image";
  VideoSettings settings;
  settings.file = (folder / "%04d.png").string();
  settings.rate = 20;
  settings.start = 7;
  HeardLog log;
  const auto frames = read_all(settings);
  std::vector<int> numbers;
  for (int i = 1; i < 20; ++i)
    if (i != 7 && i != 12 && i != 13 && i != 15 && i != 17) numbers.push_back(i);
  ASSERT_EQ(frames.size(), numbers.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(largest_difference(frames[i].colour, numbered_colour(size, numbers[i])), 0) << i;
    EXPECT_EQ(frames[i].utime, 7'000'000 + (numbers[i] - 1) * 50'000) << "a number is an interval";
  }
  EXPECT_THAT(log.text(), HasSubstr("%04d.png: missing are 3 of 19 images, the first 0007.png"));
  EXPECT_THAT(log.text(), HasSubstr("0015.png: is no image"));
  EXPECT_THAT(log.text(), ::testing::Not(HasSubstr("0017.png")));
}

TEST_F(VideoFiles, AWholeSequenceEndsAndSaysNothing) {
  write_sequence(3, false);
  std::ofstream(folder / "later0009.png") << "of another sequence";
  VideoSettings settings;
  settings.file = (folder / "%04d.png").string();
  HeardLog log;
  EXPECT_EQ(read_all(settings).size(), 3U);
  EXPECT_EQ(log.text(), "");
}

TEST_F(VideoFiles, DepthHasSixteenBitsInTheUnitThatIsSaid) {
  write_sequence(5, true);
  VideoSettings settings;
  settings.file = (folder / "%04d.png").string();
  settings.images = "depth";
  settings.depth_unit = 0.002;
  const auto frames = read_all(settings);
  ASSERT_EQ(frames.size(), 5U);
  EXPECT_EQ(largest_difference(frames[3].depth, 2 * numbered_depth(size, 3)), 0);
  EXPECT_TRUE(frames[3].colour.empty());
  settings.images = "colour";
  EXPECT_THAT(refusal(settings), HasSubstr("images: depth"));
}

TEST_F(VideoFiles, TheLargestDepthIsNoneInAnyUnit) {
  cv::Mat depth = numbered_depth(size, 1);
  depth.at<std::uint16_t>(5, 7) = 65535;
  cv::imwrite((folder / "0.png").string(), depth);
  VideoSettings settings;
  settings.file = (folder / "%d.png").string();
  settings.images = "depth";
  settings.depth_unit = 0.0001;
  const auto frames = read_all(settings);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].depth.at<std::uint16_t>(5, 7), 0) << "a wall 6.55 m away";
  EXPECT_EQ(frames[0].depth.at<std::uint16_t>(5, 8), (1010 + 3 * 8 + 5 + 5) / 10);
}

TEST_F(VideoFiles, WhatCannotBeReadIsNamed) {
  VideoSettings settings;
  settings.file = (folder / "none.mp4").string();
  EXPECT_THAT(refusal(settings), HasSubstr(settings.file));
  settings.file = (folder / "none%04d.png").string();
  EXPECT_THAT(refusal(settings), HasSubstr("no sequence of images"));
  write_sequence(2, false);
  settings.file = (folder / "%04d.png").string();
  settings.images = "depth";
  EXPECT_THAT(refusal(settings), HasSubstr("one channel of 16 bits"));
  settings.file.clear();
  settings.device = "/dev/video97";
  EXPECT_THAT(refusal(settings), HasSubstr("/dev/video97"));
}

}  // namespace
}  // namespace lcmslam
