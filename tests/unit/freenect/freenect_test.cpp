// The first Kinect by libfreenect, for which its stand-in plays a session that this test writes.
#ifdef LCMSLAM_TEST_FAKENECT

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <thread>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/status_t.hpp>
#include "procs/camera/camera_node.hpp"
#include "procs/camera/drivers/device_source.hpp"
#include "procs/camera/drivers/open_driver.hpp"
#include "procs/camera/drivers/wall_clock.hpp"
#include "tests/support/written_head.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using testing::largest_difference;

const cv::Size size{640, 480};
constexpr int shots = 60;  // half of them are read by the driver alone, half by the camera process
constexpr double interval = 1 / 30.0;  // s

cv::Mat disparities(int number) {
  cv::Mat image(size, CV_16UC1);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u)
      image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(400 + u + v / 8 + number);
  image.at<std::uint16_t>(0, 0) = 2047;  // no measurement
  return image;
}

/// Millimetres by the published fit of Kinects' disparities.
cv::Mat depth_of(const cv::Mat& raw) {
  cv::Mat depth(size, CV_16UC1);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const double z = 1 / (-0.0030711016 * raw.at<std::uint16_t>(v, u) + 3.3309495161);
      depth.at<std::uint16_t>(v, u) = z < 0.3 || z > 10 ? 0 : static_cast<std::uint16_t>(1000 * z + 0.5);
    }
  return depth;
}

/// The folder of one session: each line of INDEX.txt names a file by kind, time (s) and ticks of 60 MHz.
class Session {
 public:
  Session() {
    std::ofstream index(folder_ / "INDEX.txt");
    for (int i = 0; i < shots; ++i) {
      const double time = 1 + i * interval;
      // A counter of 32 bits that ends on the way.
      const auto ticks =
          static_cast<std::uint32_t>(0xffffffff - 30'000'000 + i * std::llround(60e6 * interval));
      const cv::Mat bgr = testing::numbered_colour(size, i);
      cv::Mat rgb = bgr.clone();
      rgb.forEach<cv::Vec3b>([](cv::Vec3b& p, const int*) { std::swap(p[0], p[2]); });
      write(index, 'r', "ppm", time, ticks, "P6 640 480 255 \n", rgb);
      write(index, 'd', "pgm", time + 0.004, ticks + 240'000, "P5 640 480 65535 \n", disparities(i));
    }
    index.close();
    setenv("FAKENECT_PATH", folder_.text().c_str(), 1);
  }

 private:
  void write(std::ofstream& index, char kind, const char* suffix, double time, std::uint32_t ticks,
             const std::string& header, const cv::Mat& image) const {
    char name[64];
    std::snprintf(name, sizeof name, "%c-%f-%u-0.%s", kind, time, ticks, suffix);
    std::ofstream out(folder_ / name, std::ios::binary);
    out << header;
    out.write(reinterpret_cast<const char*>(image.data),
              static_cast<std::streamsize>(image.total() * image.elemSize()));
    index << name << '\n';
  }
  testing::TemporaryFolder folder_;
};

/// A process can read a session but once, so both halves are one test.
TEST(Freenect, TheDriverAndTheCameraProcessGiveWhatTheKinectMeasured) {
  const Session session;
  {
    const auto camera = open_freenect({}, {true, true, false});
    std::vector<RgbdFrame> frames;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (frames.size() < shots / 2 && std::chrono::steady_clock::now() < end)
      if (auto frame = camera->read(milliseconds(100))) {
        // The stand-in falls behind its own stamps where the machine is busy: only the first is of now.
        EXPECT_LE(frame->utime, wall_clock());
        if (frames.empty()) {
          EXPECT_NEAR(static_cast<double>(frame->utime), static_cast<double>(wall_clock()), 1e6);
        }
        frames.push_back(std::move(*frame));
      }
    ASSERT_EQ(frames.size(), static_cast<std::size_t>(shots / 2));
    for (int i = 0; i < shots / 2; ++i) {
      const RgbdFrame& frame = frames[static_cast<std::size_t>(i)];
      EXPECT_EQ(largest_difference(frame.colour, testing::numbered_colour(size, i)), 0) << i;
      EXPECT_LE(largest_difference(frame.depth, depth_of(disparities(i))), 1) << i;
      EXPECT_EQ(frame.depth.at<std::uint16_t>(0, 0), 0);
      EXPECT_NEAR(static_cast<double>(frame.depth_utime - frame.utime), 4'000, 3'000) << i;
      // Delays that are shorter than any before move the clock's offset, at most by what the first ones had.
      if (i > 5) {
        EXPECT_NEAR(static_cast<double>(frame.utime - frames[static_cast<std::size_t>(i - 1)].utime), 33'333,
                    3'000)
            << i;
      }
    }
    EXPECT_THAT(camera->describe(), ::testing::HasSubstr("from disparities"));
  }

  testing::TemporaryFolder folder;
  testing::write_head(folder / "head.yaml", size, size);
  testing::CapturingPublisher publisher;
  const std::string config = "{source: freenect, live: {calibration: head.yaml}}";
  CameraNode node(ConfigNode::parse(config, (folder / "robot.yaml").string()), publisher,
                  make_source_or_device);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (node.report().detail.find("unplugged") == std::string::npos &&
         std::chrono::steady_clock::now() < end) {
    node.work();
    std::this_thread::sleep_for(milliseconds(2));
  }
  EXPECT_THAT(node.report().detail, ::testing::HasSubstr("Kinect: has been unplugged"));
  while (*node.work() == Node::Duration{0}) {
  }
  const auto messages = publisher.on<images_t>("CAMERA");
  ASSERT_GE(messages.size(), 20U);
  const RgbdCalibration calibration =
      from_message(publisher.on<camera_calibration_t>("CAMERA_CALIBRATION").at(0));
  for (const images_t& message : messages) {
    const RgbdFrame frame = decode_images(message, calibration);
    int number = -1;  // which of the session it is, by its depth: exact but for rounding
    for (int i = shots / 2; i < shots && number < 0; ++i)
      if (largest_difference(frame.depth, depth_of(disparities(i))) <= 1) number = i;
    ASSERT_GE(number, 0);
    EXPECT_LE(largest_difference(frame.colour, testing::numbered_colour(size, number)), 16) << "but for JPEG";
  }
}

TEST(Freenect, RegisteredDepthThatTheLibraryLacksIsTold) {
  try {
    open_freenect({}, {true, true, true});
    ADD_FAILURE();
  } catch (const CameraError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("depth_registered"));
  }
}

}  // namespace
}  // namespace lcmslam

#else

#include <gtest/gtest.h>

TEST(Freenect, Driver) {
  GTEST_SKIP()
      << "this build has no libfreenect, or its stand-in fakenect is not installed (libfreenect-dev)";
}

#endif
