// Answers that come late, or with holes. The map server is made up.

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include <lcmslam/map_client/map_client.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tests/support/own_bus.hpp"

namespace lcmslam {
namespace {

constexpr double long_enough = 20;  // s

const std::string& bus_url() {
  static const std::string url = own_bus(default_lcm_url);
  return url;
}

/// Answers as it is told what to do with all askings so far, in a thread of its own.
class MadeUpServer {
 public:
  using Asked = std::vector<map_request_t>;
  using Answer = std::function<std::vector<map_reply_t>(const Asked&)>;
  /// `pause`: after each tile.
  explicit MadeUpServer(Answer answer, std::chrono::milliseconds pause = std::chrono::milliseconds(0))
      : answer_(std::move(answer)), pause_(pause), publisher_(bus_.lcm(), 9, 1 << 16) {
    inputs_.subscribe<map_request_t>("MAP_REQUEST", 10, [this](const map_request_t& request) {
      asked_.push_back(request);
      for (const map_reply_t& reply : answer_(asked_)) {
        publisher_.publish("MAP_REPLY", reply);
        std::this_thread::sleep_for(pause_);
      }
    });
    receiver_.emplace(bus_, inputs_);
    thread_ = std::thread([this] {
      while (!stop_) {
        Arrival arrival;
        if (receiver_->take(arrival, std::chrono::milliseconds(20))) arrival.deliver();
      }
    });
  }
  ~MadeUpServer() { end(); }
  MadeUpServer(const MadeUpServer&) = delete;
  MadeUpServer& operator=(const MadeUpServer&) = delete;

  bool usable() { return bus_.usable(); }
  Asked end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return asked_;
  }

 private:
  Answer answer_;
  std::chrono::milliseconds pause_;
  LcmBus bus_{bus_url()};
  LcmPublisher publisher_;
  Inputs inputs_;
  std::optional<Receiver> receiver_;
  Asked asked_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

map_reply_t tile(const map_request_t& request, int number, int tiles, const std::string& bytes, int version) {
  map_reply_t reply{};
  reply.request_id = request.request_id;
  reply.tile = number;
  reply.n_tiles = tiles;
  reply.content = "application/json; frame=map; map_version=" + std::to_string(version);
  reply.data.assign(bytes.begin(), bytes.end());
  reply.size = static_cast<std::int32_t>(bytes.size());
  return reply;
}

// A server that is busy answers the first asking when others have come.
TEST(MapClient, TakesAnAnswerThatComesAfterItAskedAgain) {
  MadeUpServer server([](const MadeUpServer::Asked& asked) {
    std::vector<map_reply_t> replies;
    if (asked.size() == 3) replies = {tile(asked[0], 0, 1, "late", 4)};
    return replies;
  });
  if (!server.usable()) GTEST_SKIP() << "no multicast route here";
  MapClient map(bus_url(), long_enough);
  const MapClient::Reply reply = map.ask({FrontiersQuestion{}, long_enough});
  EXPECT_EQ(reply.bytes, "late");
  EXPECT_EQ(reply.map_version, 4);
  for (const map_request_t& request : server.end())
    EXPECT_EQ(request.argument, to_json(Question{FrontiersQuestion{}, long_enough}));
}

// A mesh of a hundred megabytes takes its time on the bus.
TEST(MapClient, TakesAnAnswerThatIsComingWhenItsTimeIsOver) {
  constexpr double deadline = 0.6;  // s; a tile after it is still within the second after which one is lost
  MadeUpServer server(
      [](const MadeUpServer::Asked& asked) {
        std::vector<map_reply_t> replies;
        for (const char* word : {"the ", "whole ", "big ", "map"})
          replies.push_back(tile(asked[0], static_cast<int>(replies.size()), 4, word, 4));
        return replies;
      },
      std::chrono::milliseconds(250));
  if (!server.usable()) GTEST_SKIP() << "no multicast route here";
  MapClient map(bus_url(), deadline);
  EXPECT_EQ(map.ask({FrontiersQuestion{}, deadline}).bytes, "the whole big map");
  EXPECT_EQ(server.end().size(), 1U);
}

TEST(MapClient, AsksAgainForWhatWasLost) {
  MadeUpServer server([](const MadeUpServer::Asked& asked) {
    std::vector<map_reply_t> replies = {tile(asked.back(), 0, 2, "the ", 4)};
    if (asked.size() == 2) replies.push_back(tile(asked.back(), 1, 2, "map", 4));
    return replies;
  });
  if (!server.usable()) GTEST_SKIP() << "no multicast route here";
  MapClient map(bus_url(), long_enough);
  EXPECT_EQ(map.ask({FrontiersQuestion{}, long_enough}).bytes, "the map");
}

// Both askings are answered, and something of the first answer is lost.
TEST(MapClient, PutsAnAnswerTogetherOfOneAnsweringOnly) {
  MadeUpServer server([](const MadeUpServer::Asked& asked) {
    std::vector<map_reply_t> replies;
    if (asked.size() == 2)
      replies = {tile(asked[0], 0, 2, "old ", 4), tile(asked[1], 1, 2, "map", 5),
                 tile(asked[1], 0, 2, "new ", 5)};
    return replies;
  });
  if (!server.usable()) GTEST_SKIP() << "no multicast route here";
  MapClient map(bus_url(), long_enough);
  const MapClient::Reply reply = map.ask({FrontiersQuestion{}, long_enough});
  EXPECT_EQ(reply.bytes, "new map");
  EXPECT_EQ(reply.map_version, 5);
}

TEST(MapClient, DoesNotTakeWhatAnotherQuestionIsAnswered) {
  MadeUpServer server([](const MadeUpServer::Asked& asked) {
    std::vector<map_reply_t> replies;
    if (asked.size() == 1) replies = {tile(asked[0], 0, 1, "first", 4)};
    if (asked.size() == 2) replies = {tile(asked[0], 0, 1, "first", 4), tile(asked[1], 0, 1, "second", 4)};
    return replies;
  });
  if (!server.usable()) GTEST_SKIP() << "no multicast route here";
  MapClient map(bus_url(), long_enough);
  EXPECT_EQ(map.ask({FrontiersQuestion{}, long_enough}).bytes, "first");
  EXPECT_EQ(map.ask({GridQuestion{}, long_enough}).bytes, "second");
}

}  // namespace
}  // namespace lcmslam
