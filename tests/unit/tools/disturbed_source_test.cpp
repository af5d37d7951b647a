// The study's camera: what is published of what it measures.

#include "tools/study/faults/disturbed_source.hpp"

#include <gmock/gmock.h>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/encoders_t.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

using ::testing::SizeIs;

/// Wheels, an image and the truth each 0.1 s, from 100.1 s on.
class TenHertz : public CameraSource {
 public:
  const RgbdCalibration& calibration() const override { return calibration_; }
  std::size_t frames() const override { return 0; }
  std::optional<CameraEvent> next() override {
    const int kind = count_ % 3;
    const Utime utime = 100'000'000 + 100'000 * (1 + count_++ / 3);
    if (kind == 0) {
      Encoders encoders;
      encoders.utime = utime;
      return encoders;
    }
    if (kind == 1) return GroundTruth{utime, "robot", Eigen::Isometry3d::Identity()};
    return shifted(frame_, utime - frame_.utime);
  }

 private:
  Random random_{1};
  RgbdCalibration calibration_ = testing::some_calibration(random_);
  EncodedFrame frame_ = testing::some_frame(random_);
  int count_ = 0;
};

TEST(DisturbedSource, AKilledCameraComesBackAsAnotherSender) {
  TenHertz camera;
  testing::CapturingPublisher first(1), second(2), stranger(3);
  DisturbedSource source(camera, first, stranger);
  EXPECT_TRUE(source.publish_until(1.05, nullptr));
  EXPECT_THAT(first.on<images_t>("CAMERA"), SizeIs(11));
  source.restart(second, 0.5);
  EXPECT_TRUE(source.publish_until(2.05, nullptr));

  EXPECT_THAT(first.on<images_t>("CAMERA"), SizeIs(11)) << "it is dead";
  const auto images = second.on<images_t>("CAMERA");
  ASSERT_THAT(images, SizeIs(6)) << "ten, of which those of half a second are lost";
  EXPECT_GE(images.front().utime, 101'600'000);
  EXPECT_EQ(origin(images.front()).sender, 2);
  EXPECT_THAT(second.on<encoders_t>("ENCODERS"), SizeIs(6));
  EXPECT_EQ(second.all.front().channel, "CAMERA_CALIBRATION") << "nobody knows it yet";
  EXPECT_THAT(source.truth(), SizeIs(21)) << "the judge knows all";
}

}  // namespace
}  // namespace lcmslam
