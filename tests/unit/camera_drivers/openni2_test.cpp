// OpenNI2's dummy camera, live and as an .oni file that OpenNI2's own recorder writes of it.
#ifdef LCMSLAM_TEST_OPENNI2

#include <OpenNI.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/wall_clock.hpp"
#include "tests/support/written_head.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using testing::largest_difference;

const cv::Size dummy_size{320, 240};

/// Opens the dummy for the whole process: its threads go on for a moment when it is closed, and then meet
/// nothing.
bool has_dummy() {
  static const bool there = [] {
    openni::OpenNI::initialize();
    auto* device = new openni::Device;
    if (device->open("Dummy") != openni::STATUS_OK) return false;
    for (const auto sensor : {openni::SENSOR_COLOR, openni::SENSOR_DEPTH}) {
      auto* stream = new openni::VideoStream;
      stream->create(*device, sensor);
      stream->start();
    }
    return true;
  }();
  return there;
}

cv::Mat pixels(const openni::VideoFrameRef& frame, int type) {
  return cv::Mat(frame.getHeight(), frame.getWidth(), type, const_cast<void*>(frame.getData())).clone();
}

/// What the dummy gave while it was recorded, by the stamp that the file has: time since the stream's first
/// image.
struct Recording {
  std::map<Utime, cv::Mat> colour, depth;
};

/// Keeps what goes into the recorder.
class Listener : public openni::VideoStream::NewFrameListener {
 public:
  Listener(std::map<Utime, cv::Mat>& images, int type) : images_(images), type_(type) {}
  void onNewFrame(openni::VideoStream& stream) override {
    openni::VideoFrameRef frame;
    if (stream.readFrame(&frame) != openni::STATUS_OK) return;
    images_[static_cast<Utime>(frame.getTimestamp())] = pixels(frame, type_);
    ++count;
  }
  std::atomic<int> count{0};

 private:
  std::map<Utime, cv::Mat>& images_;
  int type_;
};

/// OpenNI2's player hands out no image of a stream whose file does not say how it is cropped, and the dummy
/// knows no cropping. A property that the player passes over ("xnSupportedPixelFormats") makes room for one
/// that says: not.
void say_that_nothing_is_cropped(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  in.close();
  const std::string passed_over("\x18\0\0\0xnSupportedPixelFormats\0\x04\0\0\0", 32);
  const std::string cropping =
      std::string("\x10\0\0\0xnCropping\0\0\0\0\0\0\x0c\0\0\0", 24) + std::string(12, '\0');
  for (std::size_t at = bytes.find(passed_over); at != std::string::npos; at = bytes.find(passed_over))
    bytes.replace(at, cropping.size(), cropping);
  std::ofstream(file, std::ios::binary) << bytes;
}

/// As the recorder writes where the camera says that it mirrors, which the dummy cannot: in the place of
/// another number of each stream.
void say_that_it_is_mirrored(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  in.close();
  const std::string other("xnSupportedMapOutputModesCount\0\x08\0\0\0", 35);
  const std::string mirror =
      std::string("xnMirror") + std::string(23, '\0') + std::string("\x08\0\0\0\x01", 5);
  for (std::size_t at = bytes.find(other); at != std::string::npos; at = bytes.find(other))
    bytes.replace(at, mirror.size(), mirror);
  std::ofstream(file, std::ios::binary) << bytes;
}

Recording record(const std::string& file, int images) {
  Recording seen;
  openni::Device device;
  openni::VideoStream colour, depth;
  if (device.open("Dummy") != openni::STATUS_OK) throw std::runtime_error("no dummy");
  colour.create(device, openni::SENSOR_COLOR);
  depth.create(device, openni::SENSOR_DEPTH);
  Listener colour_listener(seen.colour, CV_8UC3), depth_listener(seen.depth, CV_16UC1);
  {
    openni::Recorder recorder;
    recorder.create(file.c_str());
    recorder.attach(colour, false);
    recorder.attach(depth, false);
    colour.addNewFrameListener(&colour_listener);
    depth.addNewFrameListener(&depth_listener);
    recorder.start();
    colour.start();
    depth.start();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    openni::VideoStream* streams[] = {&colour, &depth};
    int index = 0;
    while ((colour_listener.count < images || depth_listener.count < images) &&
           std::chrono::steady_clock::now() < end)
      openni::OpenNI::waitForAnyStream(streams, 2, &index, 20);
    colour.removeNewFrameListener(&colour_listener);
    depth.removeNewFrameListener(&depth_listener);
    recorder.stop();
    colour.stop();
    depth.stop();
    recorder.destroy();
  }
  say_that_nothing_is_cropped(file);
  return seen;
}

std::vector<RgbdFrame> read_all(const OpenNi2Settings& settings, const WantedImages& wanted) {
  const auto camera = open_openni2(settings, wanted);
  std::vector<RgbdFrame> frames;
  while (!camera->ended())
    if (auto frame = camera->read(milliseconds(100))) frames.push_back(std::move(*frame));
  while (auto frame = camera->read(milliseconds(0))) frames.push_back(std::move(*frame));
  return frames;
}

class OpenNi2 : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_dummy()) GTEST_SKIP() << "OpenNI2's dummy driver is not installed (libDummyDevice.so)";
  }
  testing::TemporaryFolder folder;
};

TEST_F(OpenNi2, ARecordingIsReadImageByImageWithItsStamps) {
  OpenNi2Settings settings;
  settings.file = (folder / "dummy.oni").string();
  settings.start = 100;
  const Recording seen = record(settings.file, 25);
  ASSERT_GE(seen.colour.size(), 20U);
  const auto colour = read_all(settings, {true, false, false});
  OpenNi2Settings copy = settings;
  copy.file = (folder / "copy.oni").string();
  std::filesystem::copy_file(settings.file, copy.file);
  const auto depth = read_all(copy, {false, true, false});
  ASSERT_GE(colour.size(), 20U);
  ASSERT_GE(depth.size(), 20U);
  // The recorder counts from each stream's first image, whose stamp the listener may have missed by some.
  const auto find = [](const std::map<Utime, cv::Mat>& images, const cv::Mat& image) {
    Utime at = -1;
    for (const auto& [utime, pixels] : images)
      if (largest_difference(pixels, image) == 0) at = utime;
    return at;
  };
  int compared = 0;
  for (const auto* frames : {&colour, &depth}) {
    const bool is_depth = frames == &depth;
    const auto& originals = is_depth ? seen.depth : seen.colour;
    std::optional<Utime> offset;
    for (const RgbdFrame& frame : *frames) {
      cv::Mat rgb = frame.colour;
      if (!is_depth) {
        rgb = frame.colour.clone();
        rgb.forEach<cv::Vec3b>([](cv::Vec3b& p, const int*) { std::swap(p[0], p[2]); });
      }
      const Utime original = find(originals, is_depth ? frame.depth : rgb);
      if (original < 0) continue;  // before the listener or after it
      ++compared;
      if (!offset) offset = frame.utime - original;
      EXPECT_EQ(frame.utime - original, *offset) << "the stamps' distances are not the camera's";
      EXPECT_GE(frame.utime, 100'000'000);
    }
  }
  EXPECT_GE(compared, 40);
  EXPECT_EQ(colour.front().utime, 100'000'000);
  for (std::size_t i = 1; i < depth.size(); ++i) EXPECT_EQ(depth[i].utime - depth[i - 1].utime, 33'000);
}

TEST_F(OpenNi2, BothImagesOfARecordingComeAsPairs) {
  OpenNi2Settings settings;
  settings.file = (folder / "dummy.oni").string();
  record(settings.file, 25);
  const auto frames = read_all(settings, {true, true, false});
  ASSERT_GE(frames.size(), 20U);
  for (const RgbdFrame& frame : frames) {
    EXPECT_EQ(frame.colour.size(), dummy_size);
    EXPECT_EQ(frame.depth.size(), dummy_size);
    EXPECT_EQ(frame.utime, frame.depth_utime) << "both began at 0 and count in steps of 33 ms";
  }
}

TEST_F(OpenNi2, AMirroredRecordingIsTurnedOver) {
  OpenNi2Settings settings;
  settings.file = (folder / "dummy.oni").string();
  const Recording seen = record(settings.file, 25);
  say_that_it_is_mirrored(settings.file);
  int turned = 0;
  for (const RgbdFrame& frame : read_all(settings, {true, true, false})) {
    const auto is_turned = [](const auto& images, const cv::Mat& image) {
      cv::Mat back;
      cv::flip(image, back, 1);
      return std::any_of(images.begin(), images.end(), [&](const auto& original) {
        return largest_difference(original.second, back) == 0 &&
               largest_difference(original.second, image) > 0;
      });
    };
    cv::Mat rgb = frame.colour.clone();
    rgb.forEach<cv::Vec3b>([](cv::Vec3b& p, const int*) { std::swap(p[0], p[2]); });
    turned += is_turned(seen.colour, rgb) && is_turned(seen.depth, frame.depth) ? 1 : 0;
  }
  EXPECT_GE(turned, 15) << "but for those before and after the listener";
}

TEST_F(OpenNi2, ACameraGivesPairsAtItsPaceStampedByItsOwnClock) {
  OpenNi2Settings settings;
  settings.device = "Dummy";
  settings.width = dummy_size.width;
  settings.height = dummy_size.height;
  const auto camera = open_openni2(settings, {true, true, false});
  EXPECT_THAT(camera->describe(), ::testing::HasSubstr("320x240, 30 Hz"));
  std::vector<RgbdFrame> frames;
  const auto begin = std::chrono::steady_clock::now();
  while (frames.size() < 30 && std::chrono::steady_clock::now() < begin + std::chrono::seconds(10)) {
    auto frame = camera->read(milliseconds(100));
    if (!frame) continue;
    // The dummy falls behind its own stamps where the machine is busy: only the first is of now.
    EXPECT_LE(frame->utime, wall_clock());
    if (frames.empty()) {
      EXPECT_NEAR(static_cast<double>(frame->utime), static_cast<double>(wall_clock()), 1e6);
    }
    frames.push_back(std::move(*frame));
  }
  ASSERT_EQ(frames.size(), 30U);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    EXPECT_GT(frames[i].utime, frames[i - 1].utime);
    EXPECT_EQ((frames[i].utime - frames[i].depth_utime) % 33'000, 0) << "one clock for both";
    EXPECT_LE(std::abs(frames[i].utime - frames[i].depth_utime), 16'667);
  }
  std::vector<Utime> intervals;
  for (std::size_t i = 1; i < frames.size(); ++i) intervals.push_back(frames[i].utime - frames[i - 1].utime);
  std::sort(intervals.begin(), intervals.end());
  EXPECT_NEAR(static_cast<double>(intervals[intervals.size() / 2]), 33'000, 1'000);
}

TEST_F(OpenNi2, ARegistrationThatACameraLacksIsToldAndWhatIsNotThereIsNamed) {
  const auto refusal = [](const OpenNi2Settings& settings, bool registered) -> std::string {
    try {
      open_openni2(settings, {true, true, registered});
    } catch (const CameraError& error) {
      return error.what();
    }
    return "";
  };
  OpenNi2Settings settings;
  settings.device = "Dummy";
  EXPECT_THAT(refusal(settings, true), ::testing::HasSubstr("depth_registered"));
  settings.device = "nobody's";
  EXPECT_THAT(refusal(settings, false), ::testing::HasSubstr("nobody's: "));
  EXPECT_THAT(refusal(settings, false), ::testing::HasSubstr("there are: Dummy"));
  settings.file = (folder / "none.oni").string();
  EXPECT_THAT(refusal(settings, false), ::testing::HasSubstr(settings.file));
}

}  // namespace
}  // namespace lcmslam

#else

#include <gtest/gtest.h>

TEST(OpenNi2, Driver) {
  GTEST_SKIP() << "this build has no OpenNI2 (libopenni2-dev)";
}

#endif
