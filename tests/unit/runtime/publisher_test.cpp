#include <lcmslam/runtime/publisher.hpp>

#include <gmock/gmock.h>

#include <lcmslam/encoders_t.hpp>
#include <lcmslam/pose_t.hpp>
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

encoders_t wheels_at(Utime utime, int wheels = 0) {
  encoders_t m;
  m.utime = utime;
  m.n_wheels = wheels;
  m.wheels.resize(static_cast<std::size_t>(wheels));
  return m;
}

TEST(Publisher, NumbersEachChannelByItself) {
  testing::CapturingPublisher publisher(99);
  for (int i = 0; i < 3; ++i) {
    publisher.publish("A", wheels_at(10 + i));
    if (i < 2) publisher.publish("B", wheels_at(20 + i));
  }
  const auto a = publisher.on<encoders_t>("A"), b = publisher.on<encoders_t>("B");
  ASSERT_EQ(a.size(), 3U);
  ASSERT_EQ(b.size(), 2U);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].seq, static_cast<std::int64_t>(i));
  for (std::size_t i = 0; i < b.size(); ++i) EXPECT_EQ(b[i].seq, static_cast<std::int64_t>(i));
  for (const auto& m : a) EXPECT_EQ(m.sender, 99);
}

TEST(Publisher, WhatIsHandedOnTakesNoNumber) {
  testing::CapturingPublisher publisher(99);
  encoders_t others = wheels_at(10);
  others.seq = 70;
  others.sender = 5;
  publisher.publish("A", wheels_at(1));
  publisher.forward("A", encode_message(others), 10);
  publisher.publish("A", wheels_at(2));
  const auto a = publisher.on<encoders_t>("A");
  ASSERT_EQ(a.size(), 3U);
  EXPECT_EQ(a[1].seq, 70);
  EXPECT_EQ(a[2].seq, 1) << "a gap would be taken for a loss";
  EXPECT_EQ(publisher.counts().at("A").sent, 3);
}

TEST(Publisher, CountsMessagesAndBytes) {
  testing::CapturingPublisher publisher;
  publisher.publish("A", wheels_at(10, 4));
  publisher.publish("A", wheels_at(11, 1));
  const OutputCount count = publisher.counts().at("A");
  EXPECT_EQ(count.sent, 2);
  EXPECT_EQ(count.largest, static_cast<std::int64_t>(publisher.all[0].bytes.size()));
  EXPECT_EQ(count.bytes,
            static_cast<std::int64_t>(publisher.all[0].bytes.size() + publisher.all[1].bytes.size()));
  EXPECT_EQ(count.last_utime, 11);
}

TEST(Publisher, TellsWhichMeasurementWasAnswered) {
  testing::CapturingPublisher publisher;
  std::vector<Utime> answered;
  publisher.on_answer = [&](Utime utime) { answered.push_back(utime); };
  publisher.publish("A", wheels_at(10));
  publisher.publish("A", wheels_at(11), 9);
  EXPECT_THAT(answered, ::testing::ElementsAre(10, 9));
}

TEST(Publisher, ForeignTypesGoOutUnchangedAndBatchTakesNoTime) {
  testing::CapturingPublisher publisher;
  pose_t pose{};
  pose.utime = 5;
  publisher.publish("POSE_BODY", pose);
  EXPECT_EQ(publisher.all[0].bytes, encode_message(pose));
  EXPECT_EQ(publisher.cpu_time(), 0);
}

}  // namespace
}  // namespace lcmslam
