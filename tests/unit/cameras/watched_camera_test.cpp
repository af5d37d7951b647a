// A camera that follows a script, watched by a clock that the test moves.

#include <lcmslam/cameras/watched_camera.hpp>

#include <gmock/gmock.h>

#include <deque>

namespace lcmslam {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

RgbdFrame shot(Utime utime, cv::Size colour = {64, 48}, cv::Size depth = {32, 24}) {
  RgbdFrame frame;
  frame.utime = frame.depth_utime = utime;
  frame.colour = cv::Mat::zeros(colour, CV_8UC3);
  frame.depth = cv::Mat::zeros(depth, CV_16UC1);
  return frame;
}

/// What happens at the test's desk: what the camera does next, and the time.
struct Desk {
  WatchedCamera::Time now{std::chrono::hours(1)};
  bool plugged = true;
  bool silent = false;
  bool ended = false;
  std::function<RgbdFrame(Utime)> image = [](Utime stamp) { return shot(stamp); };
  Utime utime = 1'000'000;
  int opened = 0, alive = 0;
};

class ScriptedCamera : public CameraDevice {
 public:
  explicit ScriptedCamera(Desk& desk) : desk_(desk) {
    if (!desk.plugged) throw CameraError("/dev/video0: No such device");
    ++desk.opened;
    ++desk.alive;
  }
  ~ScriptedCamera() override { --desk_.alive; }

  std::optional<CameraShot> read(milliseconds patience) override {
    if (!desk_.plugged) throw CameraError("/dev/video0: the device is gone");
    if (desk_.silent || desk_.ended) {
      desk_.now += patience;
      return std::nullopt;
    }
    desk_.now += milliseconds(33);
    desk_.utime += 33'000;
    return desk_.image(desk_.utime);
  }
  bool ended() const override { return desk_.ended; }
  std::string describe() const override { return "a camera of " + std::to_string(desk_.opened); }

 private:
  Desk& desk_;
};

class Watched : public ::testing::Test {
 protected:
  /// Steps for a time by the test's clock; gives the images that came.
  std::size_t run(double seconds) {
    const auto end = desk.now + std::chrono::duration_cast<WatchedCamera::Time::duration>(
                                    std::chrono::duration<double>(seconds));
    std::size_t images = 0;
    while (desk.now < end) {
      const WatchedCamera::Step step = camera.step();
      images += step.frame ? 1 : 0;
      desk.now += step.wait;
    }
    return images;
  }

  Desk desk;
  WatchSettings settings;
  WatchedCamera camera{[this] { return std::make_unique<ScriptedCamera>(desk); },
                       ExpectedImages{{64, 48}, {32, 24}}, settings, [this] { return desk.now; }};
};

TEST_F(Watched, AHealthyCameraHasNothingToTell) {
  EXPECT_NEAR(static_cast<double>(run(10)), 303, 1);
  const CameraHealth health = camera.health();
  EXPECT_TRUE(health.open);
  EXPECT_EQ(health.trouble, "");
  EXPECT_EQ(health.dropped, 0);
  EXPECT_EQ(health.refused, 0);
  EXPECT_EQ(health.opened, 1);
  EXPECT_EQ(camera.description(), "a camera of 1");
}

TEST_F(Watched, AnUnpluggedCameraIsToldAtOnceAndComesBack) {
  run(1);
  desk.plugged = false;
  run(0.1);
  EXPECT_FALSE(camera.health().open);
  EXPECT_EQ(desk.alive, 0) << "the driver is kept open";
  EXPECT_THAT(camera.health().trouble, HasSubstr("/dev/video0: the device is gone; is tried again in 0."));
  run(3);
  EXPECT_THAT(camera.health().trouble, HasSubstr("/dev/video0: No such device"));
  EXPECT_THAT(camera.health().trouble, HasSubstr("(failed 3 times)"));
  desk.plugged = true;
  EXPECT_GT(run(3), 0U);
  EXPECT_EQ(camera.health().trouble, "");
  EXPECT_EQ(camera.health().opened, 2);
  EXPECT_EQ(camera.health().dropped, 0) << "what it did not see while it was away is not left out";
}

TEST_F(Watched, PausesDoubleUpToTheirLimitAndBeginAnew) {
  desk.plugged = false;
  const auto tried = [&](double seconds) {
    const auto before = camera.health().opening;
    run(seconds);
    return camera.health().opening - before;
  };
  // At 0, 0.5, 1.5, 3.5, 7.5, 15.5 s, then every 10 s.
  EXPECT_EQ(tried(15.4), 5);
  EXPECT_EQ(tried(100), 10);
  desk.plugged = true;
  EXPECT_GT(run(11), 0U);
  desk.plugged = false;
  run(0.1);
  EXPECT_EQ(tried(1.0), 1) << "the first pause after a good image is short again";
}

TEST_F(Watched, AStallIsToldAndReopens) {
  run(1);
  desk.silent = true;
  run(0.4);
  EXPECT_EQ(camera.health().trouble, "");
  run(0.3);
  EXPECT_THAT(camera.health().trouble, HasSubstr("no image for 0."));
  EXPECT_EQ(desk.opened, 1) << "a moment of silence is no reason to open it again";
  run(3.5);
  EXPECT_EQ(desk.opened, 2);
  desk.silent = false;
  EXPECT_GT(run(4), 0U);
  EXPECT_EQ(camera.health().trouble, "");
}

TEST_F(Watched, AStallInsideADriverIsSeenFromOutside) {
  run(1);
  desk.now += milliseconds(700);  // read() has not returned: another thread asks
  EXPECT_THAT(camera.health().trouble, HasSubstr("no image for 0.7 s"));
}

TEST_F(Watched, AnOpeningThatHangsIsSeenFromOutside) {
  std::string seen;
  WatchedCamera hanging(
      [&]() -> std::unique_ptr<CameraDevice> {
        desk.now += milliseconds(2000);
        seen = hanging.health().trouble;
        throw CameraError("gave up");
      },
      {}, settings, [this] { return desk.now; });
  hanging.step();
  EXPECT_EQ(seen, "is being opened for 2.0 s");
}

TEST_F(Watched, ACameraThatFailsWhileItIsAskedWhatItIsIsClosed) {
  struct Nameless : ScriptedCamera {
    using ScriptedCamera::ScriptedCamera;
    std::string describe() const override { throw CameraError("/dev/video0: the device is gone"); }
  };
  WatchedCamera nameless([this] { return std::make_unique<Nameless>(desk); }, {}, settings,
                         [this] { return desk.now; });
  EXPECT_NO_THROW(nameless.step());
  EXPECT_FALSE(nameless.health().open);
  EXPECT_THAT(nameless.health().trouble, HasSubstr("/dev/video0: the device is gone; is tried again"));
  EXPECT_EQ(desk.alive, 0);
}

TEST_F(Watched, ImagesOfAWrongSizeAreRefusedToldAndReopen) {
  run(1);
  desk.image = [](Utime utime) { return shot(utime, {32, 24}); };
  EXPECT_EQ(run(0.5), 0U);
  EXPECT_THAT(camera.health().trouble,
              HasSubstr("the colour image is 32x24, by its calibration it must be 64x48"));
  EXPECT_EQ(camera.health().refused, 16);
  run(4);
  EXPECT_EQ(desk.opened, 2);
  desk.image = [](Utime utime) { return shot(utime, {64, 48}, {64, 48}); };
  run(1);
  EXPECT_THAT(camera.health().trouble, HasSubstr("the depth image is 64x48"));
  desk.image = [](Utime utime) { return shot(utime, {64, 48}, {0, 0}); };
  run(0.1);
  EXPECT_THAT(camera.health().trouble, HasSubstr("the depth image is missing"));
}

TEST_F(Watched, ImagesThatTheCameraLeftOutAreCounted) {
  run(2);
  desk.utime += 33'000;  // one
  run(0.1);
  EXPECT_EQ(camera.health().dropped, 1);
  desk.utime += 4 * 33'000;
  run(0.1);
  EXPECT_EQ(camera.health().dropped, 5);
  EXPECT_EQ(camera.health().trouble, "");
  desk.utime += 3'600'000'000;  // NTP sets the clock
  run(0.1);
  EXPECT_EQ(camera.health().dropped, 5);
}

TEST_F(Watched, StampsThatGoBackAreRefusedButATimeThatBeganAnewIsNot) {
  run(1);
  desk.utime -= 200'000;
  run(0.1);
  EXPECT_GT(camera.health().refused, 0);
  EXPECT_THAT(camera.health().trouble, HasSubstr("stamp"));
  run(1);
  EXPECT_EQ(camera.health().trouble, "");
  const auto refused = camera.health().refused;
  desk.utime = 10'000;
  EXPECT_GT(run(0.2), 0U);
  EXPECT_EQ(camera.health().refused, refused);
}

TEST_F(Watched, ACameraThatChangesItsPaceDropsNothing) {
  FrameGaps gaps;
  Utime utime = 0;
  std::int64_t missing = 0;
  for (int i = 0; i < 100; ++i) missing += gaps.missing_before(utime += 33'333 + (i % 3 - 1) * 8'000);
  EXPECT_EQ(missing, 0) << "jitter of a quarter interval is no gap";
  EXPECT_NEAR(static_cast<double>(gaps.usual_interval()), 33'333, 8'000);
  for (int i = 0; i < 100; ++i) missing += gaps.missing_before(utime += 66'667);
  EXPECT_LE(missing, 8) << "the half pace of a long exposure becomes the usual one";
  EXPECT_EQ(gaps.missing_before(utime += 2 * 66'667), 1);
}

}  // namespace
}  // namespace lcmslam
