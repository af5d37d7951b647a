// Channels, topics, brokers, pictures: what the bridge is told.

#include <gmock/gmock.h>

#include <sys/stat.h>
#include <fstream>

#include <lcmslam/bridge/broker.hpp>
#include <lcmslam/bridge/channel_rule.hpp>
#include <lcmslam/bridge/smaller_picture.hpp>
#include <lcmslam/bridge/token_bucket.hpp>
#include <lcmslam/bridge/topics.hpp>
#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam::bridge {
namespace {

using ::testing::HasSubstr;

TEST(ChannelRules, AreReadOrRefusedWithWhatWouldBeRight) {
  EXPECT_EQ(parse_rule("ICP_POSE@2.5").channel, "ICP_POSE");
  EXPECT_EQ(parse_rule("ICP_POSE@2.5").rate, 2.5);
  EXPECT_EQ(parse_rule("COMMAND").rate, 0);
  for (const char* wrong : {"", "@5", "A/B", "A+", "#", "A@", "A@x", "A@0", "A@-1", "A@5x", "A@nan", "A B"})
    EXPECT_THROW(parse_rule(wrong), std::invalid_argument) << wrong;
  EXPECT_THROW(parse_rules({"A@1", "B", "A"}), std::invalid_argument);
}

TEST(Topics, RobotAndOperatorMeet) {
  const Topics robot("lab/lcmslam", "dora", Side::robot), other("lab/lcmslam", "dora", Side::operating);
  EXPECT_EQ(robot.outgoing("ICP_POSE"), "lab/lcmslam/dora/from/ICP_POSE");
  EXPECT_EQ(other.incoming("ICP_POSE"), "lab/lcmslam/dora/from/ICP_POSE/#");
  EXPECT_EQ(other.channel_of(robot.outgoing("ICP_KEYFRAME/1/2")), "ICP_KEYFRAME");
  EXPECT_EQ(robot.channel_of(other.outgoing("COMMAND")), "COMMAND");
  EXPECT_EQ(robot.channel_of(robot.outgoing("COMMAND")), "") << "its own";
  EXPECT_EQ(robot.channel_of("lab/lcmslam/ed/to/COMMAND"), "") << "another robot's";
  EXPECT_EQ(robot.channel_of("lab/lcmslam/dora/to/"), "");
  EXPECT_NE(robot.mark(), other.mark());
  EXPECT_THROW(Topics("a#", "dora", Side::robot), std::invalid_argument);
  EXPECT_THROW(Topics("a", "do/ra", Side::robot), std::invalid_argument);
  EXPECT_THROW(Topics("a", "", Side::robot), std::invalid_argument);
}

TEST(Brokers, OnOtherMachinesAreSpokenToEncryptedAndByName) {
  Broker broker;
  for (const char* here : {"localhost", "127.0.0.1", "127.1.2.3", "::1"}) {
    broker.host = here;
    EXPECT_EQ(objection(broker), "") << here;
  }
  for (const char* there : {"10.0.0.5", "broker.example", "127.evil.example", "localhost.example"}) {
    broker.host = there;
    EXPECT_THAT(objection(broker), HasSubstr("readable and forgeable")) << there;
  }
  broker.certificates = "/etc/ssl/certs";
  EXPECT_THAT(objection(broker), HasSubstr("who this bridge is"));
  broker.user = "dora";
  EXPECT_EQ(objection(broker), "");
}

TEST(Brokers, APasswordIsItsOwnersAlone) {
  const std::string file = ::testing::TempDir() + "bridge_password";
  std::ofstream(file) << "secret word\nsecond line\n";
  chmod(file.c_str(), 0644);
  EXPECT_THROW(read_password(file), std::invalid_argument);
  chmod(file.c_str(), 0600);
  EXPECT_EQ(read_password(file), "secret word");
  EXPECT_THROW(read_password(file + "-missing"), std::invalid_argument);
}

TEST(TokenBucket, AllowsABurstAndThenItsRate) {
  TokenBucket bucket(10, 5);
  TokenBucket::Time now(std::chrono::seconds(100));
  int passed = 0;
  for (int i = 0; i < 100; ++i) passed += bucket.try_take(1, now) ? 1 : 0;
  EXPECT_EQ(passed, 5);
  for (int i = 0; i < 1000; ++i) passed += bucket.try_take(1, now += std::chrono::milliseconds(10)) ? 1 : 0;
  EXPECT_NEAR(passed, 105, 1);
  EXPECT_TRUE(TokenBucket(0, 1).try_take(1e9, now)) << "no limit";
}

TEST(SmallerPicture, IsOneThatDecodesAndIsSmall) {
  cv::Mat image(480, 640, CV_8UC3);
  cv::randu(image, 0, 255);
  EncodedFrame frame;
  frame.utime = 5;
  frame.sensor = "head";
  frame.colour = encode_colour(image, 4, 90);
  frame.depth = encode_depth(cv::Mat(100, 100, CV_16UC1, cv::Scalar(1000)), 3);
  const EncodedFrame smaller = smaller_picture(frame, 320, 50);
  const cv::Mat decoded = decode_colour(smaller.colour);
  EXPECT_EQ(decoded.cols, 320);
  EXPECT_EQ(decoded.rows, 240);
  EXPECT_LT(smaller.colour.bytes.size(), frame.colour.bytes.size() / 4);
  EXPECT_EQ(smaller.depth.coding, ImageCoding::none);
  EXPECT_EQ(smaller.utime, 5);
  EXPECT_EQ(smaller.colour.utime, 4);
  EXPECT_EQ(decode_colour(smaller_picture(frame, 1000, 50).colour).cols, 640) << "never larger";
}

}  // namespace
}  // namespace lcmslam::bridge
