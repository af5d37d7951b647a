#include <lcmslam/runtime/outage.hpp>

#include <gmock/gmock.h>

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <algorithm>
#include <sstream>

#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/private_bus.hpp>

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

TEST(OutageTest, IsSaidEverMoreSeldomAndEachAnew) {
  Outage outage;
  EXPECT_EQ(outage.over(), 0);
  for (int round = 0; round < 2; ++round) {
    int said = 0;
    for (int i = 0; i < 100; ++i) said += outage.failed() ? 1 : 0;
    EXPECT_EQ(said, 7);
    EXPECT_EQ(outage.over(), 100);
    EXPECT_EQ(outage.over(), 0);
  }
}

/// What goes to the log while it lives.
class LogOfAnOutage {
 public:
  LogOfAnOutage() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("heard", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~LogOfAnOutage() { spdlog::set_default_logger(before_); }
  LogOfAnOutage(const LogOfAnOutage&) = delete;
  LogOfAnOutage& operator=(const LogOfAnOutage&) = delete;
  std::string text() const { return text_.str(); }
  std::ptrdiff_t lines() const {
    const std::string all = text();
    return std::count(all.begin(), all.end(), '\n');
  }

 private:
  std::shared_ptr<spdlog::logger> before_;
  std::ostringstream text_;
};

TEST(OutageTest, ARouteThatIsGoneForAWhileDoesNotFloodTheLog) {
  if (!enter_private_bus()) GTEST_SKIP() << "no private network namespace on this machine";
  LcmBus bus("udpm://239.255.76.67:7667?ttl=0");
  ASSERT_TRUE(bus.usable());
  BusSender sender(bus.lcm(), 7, 1 << 20);
  const auto send = [&](int times) {
    for (int i = 0; i < times; ++i) sender.send("ENCODERS", {1, 2, 3}, 0);
  };
  const LogOfAnOutage log;
  send(1);
  ASSERT_EQ(std::system("ip route del 224.0.0.0/4 dev lo"), 0);
  send(100);
  EXPECT_EQ(sender.failed(), 100);
  EXPECT_EQ(log.lines(), 7) << log.text();
  EXPECT_THAT(log.text(),
              HasSubstr("ENCODERS: LCM could not send 3 bytes: Network is unreachable (1 so far"));
  EXPECT_THAT(log.text(), HasSubstr("doctor"));
  ASSERT_EQ(std::system("ip route add 224.0.0.0/4 dev lo"), 0);
  send(2);
  EXPECT_EQ(sender.failed(), 100);
  EXPECT_THAT(log.text(), HasSubstr("ENCODERS: LCM sends again, 100 were not sent"));
  EXPECT_EQ(log.lines(), 8) << log.text();
}

}  // namespace
}  // namespace lcmslam
