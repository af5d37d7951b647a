#include <lcmslam/runtime/log_publisher.hpp>

#include <gtest/gtest.h>

#include <filesystem>

#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/pose_t.hpp>

namespace lcmslam {
namespace {

pose_t pose(Utime utime) {
  pose_t m{};
  m.utime = utime;
  return m;
}

class LogPublisherTest : public ::testing::Test {
 protected:
  LogPublisherTest() { std::filesystem::create_directories(folder_); }
  ~LogPublisherTest() override { std::filesystem::remove_all(folder_); }
  const std::filesystem::path folder_ = ::testing::TempDir() + "log_publisher";
  const std::string file_ = folder_ / "published.lcmlog";
};

TEST_F(LogPublisherTest, WritesMessagesAtTheirOwnTimes) {
  LogPublisher publisher(file_);
  publisher.publish("A", pose(5));
  publisher.publish("B", pose(3), 1);
  publisher.close();

  LogReader log(file_);
  std::int64_t bytes = 0;
  for (const auto& [channel, utime] : {std::pair("A", 5), std::pair("B", 3)}) {
    const auto event = log.next_view();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->channel, channel);
    EXPECT_EQ(event->timestamp, utime);
    EXPECT_EQ(decode_message<pose_t>(event->data, event->size).utime, utime);
    bytes += static_cast<std::int64_t>(event->size);
  }
  EXPECT_FALSE(log.next_view());
  EXPECT_EQ(publisher.bytes(), bytes);
}

TEST_F(LogPublisherTest, LeavesNoFileUnlessClosed) {
  { LogPublisher(file_).publish("A", pose(5)); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace lcmslam
