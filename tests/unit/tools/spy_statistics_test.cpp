#include "tools/spy/bus_statistics.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pointcloud2_t.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

pose_estimate_t pose(std::int64_t seq, std::int64_t sender = 7, Utime utime = 5'000'000) {
  pose_estimate_t message{};
  message.utime = utime;
  message.seq = seq;
  message.sender = sender;
  return message;
}

class Statistics : public ::testing::Test {
 protected:
  void add(const std::string& channel, const Bytes& bytes) {
    statistics_.add(channel, bytes.data(), bytes.size(), time_);
  }
  template <class M>
  void add(const std::string& channel, const M& message) {
    add(channel, encode_message(message));
  }
  ChannelReport report(const std::string& channel) const {
    for (const ChannelReport& report : statistics_.channels(time_))
      if (report.channel == channel) return report;
    ADD_FAILURE() << "no channel " << channel;
    return {};
  }

  BusStatistics statistics_;
  double time_ = 100;
};

TEST_F(Statistics, CountsSizesAndAgeOfEachChannel) {
  status_t status{};
  add("STATUS", status);
  time_ += 0.5;
  status.detail = "longer";
  add("STATUS", status);
  add("POSE", pose(0));
  time_ += 2;
  const ChannelReport s = report("STATUS");
  EXPECT_EQ(s.type, "status_t");
  EXPECT_EQ(s.count, 2);
  EXPECT_EQ(s.largest, encode_message(status).size());
  EXPECT_DOUBLE_EQ(s.age, 2);
  EXPECT_EQ(report("POSE").count, 1);
  EXPECT_EQ(statistics_.channels(time_).size(), 2U);
}

TEST_F(Statistics, GapsAreCountedForEachSenderByItself) {
  for (const std::int64_t seq : {10, 11, 13, 14, 18}) add("POSE", pose(seq, 1));
  for (const std::int64_t seq : {500, 501, 502}) add("POSE", pose(seq, 2));
  add("POSE", pose(19, 1));
  const ChannelReport r = report("POSE");
  EXPECT_EQ(r.senders, 2U);
  EXPECT_EQ(r.lost, 1 + 3);
  EXPECT_EQ(r.duplicates, 0);
  EXPECT_EQ(r.reordered, 0);
}

TEST_F(Statistics, DuplicatesAndDisorderAreNoLoss) {
  for (const std::int64_t seq : {0, 1, 1, 3, 2, 4}) add("POSE", pose(seq));
  const ChannelReport r = report("POSE");
  EXPECT_EQ(r.lost, 0);
  EXPECT_EQ(r.duplicates, 1);
  EXPECT_EQ(r.reordered, 1);
}

TEST_F(Statistics, RandomLossIsCountedExactly) {
  Random random(1);
  std::int64_t lost = 0, waiting = 0;
  add("POSE", pose(0));
  for (std::int64_t seq = 1; seq < 2000; ++seq) {
    if (random.below(4) == 0) {
      ++waiting;
      continue;
    }
    add("POSE", pose(seq));
    lost += waiting;
    waiting = 0;
  }
  EXPECT_GT(lost, 300);
  EXPECT_EQ(report("POSE").lost, lost);
}

TEST_F(Statistics, NumbersOfImagesAreInTheirMetadata) {
  for (const std::int64_t seq : {5, 6, 9}) {
    images_t images;
    images.utime = 1;
    images.n_images = 1;
    images.image_types = {0};
    images.images.resize(1);
    images.images[0].size = 200'000;
    images.images[0].data.resize(200'000);
    set_text(images.images[0], "sensor", "a name that is longer than eight bytes");
    set_origin(images, {seq, 3});
    add("CAMERA", images);
  }
  const ChannelReport r = report("CAMERA");
  EXPECT_EQ(r.senders, 1U);
  EXPECT_EQ(r.lost, 2);
  EXPECT_EQ(r.decode_errors, 0);
}

TEST_F(Statistics, WhoDoesNotNumberHasNoGaps) {
  images_t none{};
  add("CAMERA", none);
  pointcloud2_t cloud{};
  for (const int seq : {1, 5}) {
    cloud.seq = seq;
    add("CLOUD", cloud);
  }
  EXPECT_EQ(report("CAMERA").senders, 0U);
  EXPECT_EQ(report("CLOUD").senders, 0U);
  EXPECT_EQ(report("CLOUD").lost, 0);
}

TEST_F(Statistics, WhatDoesNotDecodeIsCountedAndIsNoGap) {
  add("POSE", pose(1));
  Bytes bytes = encode_message(pose(2));
  bytes.pop_back();
  add("POSE", bytes);
  add("POSE", pose(3));
  add("POSE", pose(5));
  add("POSE", Bytes{1, 2, 3});
  const ChannelReport r = report("POSE");
  EXPECT_EQ(r.count, 5);
  EXPECT_EQ(r.decode_errors, 2);
  EXPECT_EQ(r.lost, 1);
  EXPECT_THAT(r.last_error, HasSubstr("3 bytes are too few"));
}

TEST_F(Statistics, UnknownTypesAreNamedByTheirFingerprint) {
  add("LIDAR", Bytes{0x89, 0xdc, 0x5b, 0x87, 0x9a, 0x50, 0x56, 0xcf, 1, 2, 3});
  EXPECT_EQ(report("LIDAR").type, "?? 89dc5b879a5056cf");
  EXPECT_EQ(report("LIDAR").decode_errors, 0);
  add("LIDAR", pose(0));
  EXPECT_EQ(report("LIDAR").types, 2U);
  const std::uint64_t utime_t = MessageType::find("utime_t")->fingerprint;
  Bytes foreign(16, 0);
  for (std::size_t i = 0; i < 8; ++i) foreign[i] = static_cast<std::uint8_t>(utime_t >> (56 - 8 * i));
  add("BEAT", foreign);
  EXPECT_EQ(report("BEAT").type, "bot_core.utime_t");
}

TEST_F(Statistics, ALogThatStartsAgainIsNoDisorder) {
  for (int loop = 0; loop < 3; ++loop)
    for (std::int64_t k = 0; k < 20; ++k)
      if (k != 7) add("POSE", pose(100 + k, 1, 50'000'000 + 500'000 * k));
  const ChannelReport r = report("POSE");
  EXPECT_EQ(r.lost, 3);
  EXPECT_EQ(r.reordered, 0);
  EXPECT_EQ(r.duplicates, 0);
}

// ---- pieces

TEST_F(Statistics, PiecesAreShownAsTheMessageTheyMake) {
  std::int64_t piece_seq = 0;
  for (const std::int64_t seq : {0, 1, 3}) {
    pose_estimate_t message = pose(seq);
    message.detail = std::string(5000, 'x');
    for (part_t& part : split_message("POSE", encode_message(message), message.utime, seq, 1000)) {
      part.sender = 7;
      part.seq = piece_seq++;
      if (seq == 1 && part.part == 2) continue;  // lost
      add("POSE_PART", part);
    }
  }
  ASSERT_EQ(statistics_.channels(time_).size(), 1U);
  const ChannelReport r = report("POSE");
  EXPECT_EQ(r.type, "pose_estimate_t");
  EXPECT_EQ(r.count, 2);
  EXPECT_EQ(r.pieces, piece_seq - 1);
  EXPECT_EQ(r.lost_pieces, 1);
  EXPECT_EQ(r.incomplete, 1);
  EXPECT_EQ(r.lost, 2);  // seq 1 and 2
  EXPECT_GT(r.largest, 5000U);
}

TEST_F(Statistics, PiecesThatNameAnotherChannelOrContradictEachOtherAreBad) {
  const Bytes whole = encode_message(pose(0));
  auto parts = split_message("OTHER", whole, 0, 0, 100);
  add("POSE_PART", parts[0]);
  EXPECT_EQ(report("POSE_PART").count, 1);
  parts = split_message("POSE", whole, 0, 0, 100);
  parts[1].total_size = 5000;
  add("POSE_PART", parts[0]);
  add("POSE_PART", parts[1]);
  EXPECT_EQ(report("POSE").decode_errors, 1);
  add("FOO_PART", pose(0));  // any type may go on a channel of that name
  EXPECT_EQ(report("FOO_PART").type, "pose_estimate_t");
}

// ---- floods of garbage

TEST_F(Statistics, GarbageDoesNotGrowTheTableForEver) {
  for (int i = 0; i < 3000; ++i) add("C" + std::to_string(i), pose(0));
  EXPECT_EQ(statistics_.channels(time_).size(), 1000U);
  EXPECT_EQ(statistics_.left_out(), 2000);
  for (int i = 0; i < 3000; ++i) add("C1", pose(0, 1000 + i));
  EXPECT_LE(report("C1").senders, 65U);
  for (const std::int64_t seq : {std::int64_t{0}, std::numeric_limits<std::int64_t>::max(),
                                 std::numeric_limits<std::int64_t>::min(), std::int64_t{1}})
    for (const Utime utime : {std::numeric_limits<Utime>::min(), std::numeric_limits<Utime>::max(), Utime{0}})
      for (const std::int64_t sender : {1, 2, 3}) add("C2", pose(seq, sender, utime));
  EXPECT_GE(report("C2").lost, 0);
}

// ---- rates

TEST(ArrivalRates, OfAnEvenStream) {
  ArrivalRate rate(5);
  double time = 0;
  for (int i = 0; i < 1000; ++i) rate.add(time = 0.02 * i, 300);
  for (const double since : {0.0, 0.005, 0.0199}) {
    const auto r = rate.at(time + since);
    EXPECT_NEAR(r.hz, 50, 1e-9) << since;
    EXPECT_NEAR(r.jitter, 0, 1e-9);
    EXPECT_NEAR(r.bytes_per_second, 15'000, 1e-6);
  }
}

TEST(ArrivalRates, FallWhenMessagesStayAway) {
  ArrivalRate rate(5);
  for (int i = 0; i < 100; ++i) rate.add(0.1 * i, 1);
  const double end = 9.9;
  double before = 10;
  for (const double since : {0.5, 2.0, 4.9, 20.0, 1000.0}) {
    const double hz = rate.at(end + since).hz;
    EXPECT_LT(hz, before) << since;
    before = hz;
  }
  EXPECT_LT(before, 0.01);
}

TEST(ArrivalRates, OfASlowChannelComeFromItsLastTwoMessages) {
  ArrivalRate rate(5);
  rate.add(0, 1);
  EXPECT_EQ(rate.at(1).hz, 0);
  rate.add(20, 1);
  rate.add(40, 1);
  EXPECT_NEAR(rate.at(41).hz, 0.05, 1e-12);
}

TEST(ArrivalRates, JitterIsTheDeviationOfTheIntervals) {
  Random random(2);
  ArrivalRate rate(1000);
  double time = 0;
  for (int i = 0; i < 5000; ++i) rate.add(time += 0.1 + 0.004 * random.normal(), 1);
  EXPECT_NEAR(rate.at(time).jitter, 0.004, 0.0003);
  EXPECT_NEAR(rate.at(time).hz, 10, 0.05);
}

TEST(ArrivalRates, AllAtOnceHaveNone) {
  ArrivalRate rate(5);
  for (int i = 0; i < 10; ++i) rate.add(3, 1);
  EXPECT_EQ(rate.at(3).hz, 0);
  EXPECT_TRUE(std::isfinite(rate.at(4).hz));
}

}  // namespace
}  // namespace lcmslam
