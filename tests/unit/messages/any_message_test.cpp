#include <lcmslam/messages/any_message.hpp>

#include <gmock/gmock.h>

#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pose_estimate_t.hpp>

namespace lcmslam {
namespace {

pose_estimate_t some_pose() {
  pose_estimate_t pose{};
  pose.utime = 123'456'789;
  pose.seq = 42;
  pose.sender = -7;
  pose.frame = "map";
  return pose;
}

TEST(AnyMessage, IsKnownByItsFingerprint) {
  const auto bytes = encode_message(some_pose());
  const AnyMessage message = identify(bytes.data(), bytes.size());
  EXPECT_EQ(message.type->name, "pose_estimate_t");
  EXPECT_EQ(message.utime, 123'456'789);
  EXPECT_EQ(message.origin.seq, 42);
  EXPECT_EQ(message.origin.sender, -7);
}

TEST(AnyMessage, ANewNumberChangesNothingElse) {
  pose_estimate_t pose = some_pose();
  auto bytes = encode_message(pose);
  renumber(bytes, identify(bytes.data(), bytes.size()), 0x0102030405060708);
  pose.seq = 0x0102030405060708;
  EXPECT_EQ(bytes, encode_message(pose));
}

TEST(AnyMessage, WhatHasNoNumberStays) {
  images_t images{};
  images.utime = 5;
  auto bytes = encode_message(images);
  const auto before = bytes;
  const AnyMessage is = identify(bytes.data(), bytes.size());
  EXPECT_EQ(is.utime, 5);
  EXPECT_EQ(is.origin.seq, -1);
  renumber(bytes, is, 77);
  EXPECT_EQ(bytes, before);
}

TEST(AnyMessage, GarbageIsNone) {
  auto bytes = encode_message(some_pose());
  EXPECT_THROW(identify(bytes.data(), 7), DecodeError);
  EXPECT_THROW(identify(bytes.data(), bytes.size() - 1), DecodeError);
  bytes[3] ^= 1;
  EXPECT_THROW(identify(bytes.data(), bytes.size()), DecodeError);
}

}  // namespace
}  // namespace lcmslam
