#include <gtest/gtest.h>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/stored_calibration.hpp>

namespace lcmslam {
namespace {

RgbdCalibration some_head(double fx) {
  RgbdCalibration calibration;
  calibration.colour = calibration.depth = CameraModel{160, 120, fx, 140, 79.5, 59.5, {}};
  calibration.depth_registered = true;
  return calibration;
}

StoredImages taken_by(const RgbdCalibration& calibration) {
  StoredImages images;
  images.calibration = std::make_shared<StoredCalibration>(stored(to_message(calibration)));
  return images;
}

TEST(KnownCalibrations, AreOneObjectWhereImagesReadAlike) {
  KnownCalibrations known;
  const auto first = known.same_as(some_head(140));
  RgbdCalibration elsewhere = some_head(140);
  elsewhere.sensor = "another";
  elsewhere.T_robot_camera.translation().z() += 1;
  EXPECT_EQ(known.same_as(elsewhere), first);
  EXPECT_EQ(known.of(taken_by(some_head(140))), first);
  const auto other = known.of(taken_by(some_head(150)));
  ASSERT_TRUE(other);
  EXPECT_NE(other, first);
  EXPECT_EQ(other->colour.fx, 150);
  EXPECT_EQ(known.same_as(some_head(140)), first);
  for (int k = 0; k < 100; ++k) known.same_as(some_head(200 + k));
  EXPECT_NE(known.same_as(some_head(140)), first) << "they are bounded";
}

TEST(KnownCalibrations, AreNoneWhereNobodyCanReadThem) {
  KnownCalibrations known;
  EXPECT_EQ(known.of({}), nullptr);
  StoredImages images;
  images.calibration = std::make_shared<StoredCalibration>(StoredCalibration{"tof", "form", {1, 2, 3}});
  EXPECT_EQ(known.of(images), nullptr);
}

TEST(StoredCalibration, IsWithoutWhomItCameFrom) {
  camera_calibration_t message = to_message(some_head(140));
  const StoredCalibration before = stored(message);
  message.sender = 3, message.seq = 4, message.utime = 5;
  EXPECT_EQ(stored(message).bytes, before.bytes);
  EXPECT_TRUE(reads_alike(from_stored(before), some_head(140)));
}

}  // namespace
}  // namespace lcmslam
