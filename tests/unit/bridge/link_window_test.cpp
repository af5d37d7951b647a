// The window on links that are simulated: a rate, a way, and a queue that nobody sees.

#include <lcmslam/bridge/link_window.hpp>

#include <gmock/gmock.h>

#include <deque>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam::bridge {
namespace {

using std::chrono::milliseconds;

struct LinkResult {
  double rate = 0;     // bytes a second that arrived, in the second half
  double longest = 0;  // s that a message took, in the second half
};

/// Sends whenever the window admits it, for a minute. `loss`: share of the packets; all behind one wait until
/// it has been sent again, a time round later.
LinkResult run(double rate, double way, std::size_t size, double loss = 0) {
  Random random(1);
  LinkWindow window(0.3);
  const Time begin(std::chrono::seconds(1000));
  const auto at = [&](double t) {
    return begin + std::chrono::duration_cast<Time::duration>(std::chrono::duration<double>(t));
  };
  struct Message {
    double sent, acknowledged;
  };
  std::deque<Message> messages;
  double free = 0, held = 0;
  LinkResult result;
  for (double t = 0; t < 60; t += 0.005) {
    while (!messages.empty() && messages.front().acknowledged <= t) {
      window.acknowledged(size, at(messages.front().sent), at(t));
      if (t > 30) {
        result.rate += static_cast<double>(size) / 30;
        result.longest = std::max(result.longest, t - messages.front().sent);
      }
      messages.pop_front();
    }
    while (window.admits(size)) {
      window.sent(size);
      free = std::max(free, t) + static_cast<double>(size) / rate;
      for (std::size_t packet = 0; packet < size; packet += 1448)
        if (random.uniform() < loss) held = std::max(held, free + 4 * way);
      messages.push_back({t, std::max(held, free + 2 * way)});
    }
  }
  return result;
}

TEST(LinkWindow, FillsASlowLinkWithoutAQueue) {
  const LinkResult slow = run(250'000, 0.2, 24'000);  // 2 Mbit/s
  EXPECT_GT(slow.rate, 0.8 * 250'000);
  EXPECT_LT(slow.longest, 0.4 + 0.3 + 0.3);
  const LinkResult crawling = run(10'000, 0.2, 1'000);
  EXPECT_GT(crawling.rate, 0.8 * 10'000);
  EXPECT_LT(crawling.longest, 2.8) << "the least that is under way is 20 kB";
}

// A packet in twenty: something is held up most of the time.
TEST(LinkWindow, FillsALinkThatLosesPackets) {
  EXPECT_GT(run(250'000, 0.1, 8'000, 0.05).rate, 0.6 * 250'000);
}

// Else whoever sends small ones all the time keeps a large one waiting for ever, and all that comes after it.
TEST(LinkWindow, ALargeMessageGoesBesideSmallOnes) {
  LinkWindow window(0.3);
  window.sent(3'000);
  EXPECT_TRUE(window.admits(100'000));
  window.sent(100'000);
  EXPECT_FALSE(window.admits(100'000)) << "one";
}

TEST(LinkWindow, FillsAFastLinkToo) {
  EXPECT_GT(run(5'000'000, 0.005, 24'000).rate, 0.5 * 5'000'000);
}

TEST(LinkWindow, OneMessageAlwaysAndNotTooMany) {
  LinkWindow window(0.3);
  EXPECT_TRUE(window.admits(100'000'000));
  window.sent(100'000'000);
  EXPECT_FALSE(window.admits(10));
  window.reset();
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(window.admits(10));
    window.sent(10);
  }
  EXPECT_FALSE(window.admits(10)) << "brokers take 20 at a time";
}

}  // namespace
}  // namespace lcmslam::bridge
