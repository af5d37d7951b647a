#include <lcmslam/web/client_queue.hpp>

#include <gtest/gtest.h>
#include <algorithm>
#include <deque>
#include <nlohmann/json.hpp>

namespace lcmslam {
namespace {

BoardItem item(const std::string& channel, const std::string& key, std::size_t size,
               Haste haste = Haste::bulk, int urgency = 0) {
  return {channel, key, "{}", std::make_shared<const std::string>(size, 'x'), haste, urgency, {}};
}

std::string name(const Board::Message& message) {
  if (!message) return "nothing";
  const std::string text = message->substr(4, 80);
  const std::size_t channel = text.find(":\"") + 2, key = text.find(R"("key":")") + 7;
  const bool gone = text.find("gone") != std::string::npos;
  return text.substr(channel, text.find('"', channel) - channel) + "/" +
         text.substr(key, text.find('"', key) - key) + (gone ? " gone" : "");
}

/// All that goes out to a client who acknowledges at once.
std::vector<std::string> all(ClientQueue& queue) {
  std::vector<std::string> names;
  std::uint64_t bytes = 0;
  while (const auto message = queue.next(0)) {
    names.push_back(name(message));
    queue.acknowledged(bytes += message->size(), 0.001);
  }
  return names;
}

using Names = std::vector<std::string>;

TEST(ClientQueue, SendsEachItemOnceAndAgainWhenItChanges) {
  Board board;
  board.put(item("points", "1", 10));
  ClientQueue queue(board);
  EXPECT_EQ(all(queue), Names{"points/1"});
  EXPECT_EQ(all(queue), Names{});
  board.put(item("points", "1", 11));
  EXPECT_EQ(name(queue.next(1)), "points/1");
  EXPECT_EQ(name(queue.next(1)), "nothing");
}

TEST(ClientQueue, LiveGoesBeforeBulkAndWhatIsNearBeforeWhatIsFar) {
  Board board;
  for (const float x : {9.f, 1.f, 4.f}) {
    BoardItem far = item("mesh", std::to_string(static_cast<int>(x)), 10);
    far.place = {x, 0, 0};
    board.put(far);
  }
  board.put(item("poses", "", 10, Haste::live));
  ClientQueue queue(board);
  queue.eye({10, 0, 0});
  EXPECT_EQ(all(queue), (Names{"poses/", "mesh/9", "mesh/4", "mesh/1"}));
}

TEST(ClientQueue, AMovedEyeChangesTheOrderOfWhatWaits) {
  Board board;
  for (const float x : {9.f, 1.f}) {
    BoardItem far = item("mesh", std::to_string(static_cast<int>(x)), 10);
    far.place = {x, 0, 0};
    board.put(far);
  }
  ClientQueue queue(board);
  EXPECT_EQ(name(queue.next(0)), "mesh/1");
  board.put(item("mesh", "9", 12));
  queue.eye({10, 0, 0});
  EXPECT_EQ(all(queue), (Names{"mesh/9"}));
}

TEST(ClientQueue, WhatIsGoneIsSaidToThoseWhoHaveIt) {
  Board board;
  board.put(item("points", "1", 10));
  ClientQueue queue(board);
  all(queue);
  board.put(item("points", "2", 10));
  board.remove("points");
  EXPECT_EQ(name(queue.next(1)), "points/1 gone");
  EXPECT_EQ(name(queue.next(1)), "nothing");
}

TEST(ClientQueue, UnwantedChannelsWaitUntilTheyAreWanted) {
  Board board;
  board.put(item("points", "1", 10));
  board.put(item("mesh", "1", 10));
  board.put(item("graph", "", 10));
  ClientQueue queue(board);
  queue.want({"mesh"});
  Names first = all(queue);
  std::sort(first.begin(), first.end());
  EXPECT_EQ(first, (Names{"graph/", "mesh/1"}));
  queue.want({"mesh", "points"});
  EXPECT_EQ(all(queue), Names{"points/1"});
}

TEST(ClientQueue, LayersAreSentToThoseWhoShowThem) {
  Board board;
  for (const char* channel : {"grid", "planes", "objects"}) board.put(item(channel, "", 10));
  ClientQueue queue(board);
  queue.want({"planes"});
  EXPECT_EQ(all(queue), Names{"planes/"});
}

TEST(ClientQueue, SaysOnceThatAllOfTheFirstLookHasGoneOut) {
  Board board;
  for (const char* key : {"1", "2", "3"}) board.put(item("mesh", key, 10));
  board.put(item("grid", "", 10));
  ClientQueue queue(board);
  queue.want({"mesh"});
  EXPECT_EQ(name(queue.whole(0)), "nothing") << "it has not looked";
  EXPECT_EQ(name(queue.next(0)), "mesh/1");
  board.remove("mesh", "2");
  board.put(item("mesh", "3", 11));
  board.put(item("mesh", "4", 10));
  EXPECT_EQ(name(queue.whole(0)), "nothing");
  EXPECT_EQ(name(queue.next(0)), "mesh/3");
  EXPECT_EQ(name(queue.whole(0)), "whole/") << "the grid is not wanted, and 4 came later";
  EXPECT_EQ(name(queue.next(0)), "mesh/4");
  EXPECT_EQ(name(queue.whole(0)), "nothing");
}

TEST(ClientQueue, OnePictureIsUnderWayAtATime) {
  Board board;
  board.put(item("image", "", 1000, Haste::picture));
  ClientQueue queue(board);
  const auto first = queue.next(0);
  ASSERT_EQ(name(first), "image/");
  board.put(item("image", "", 1001, Haste::picture));
  board.put(item("graph", "", 10));
  EXPECT_EQ(name(queue.next(0.1)), "graph/");
  EXPECT_EQ(name(queue.next(0.1)), "nothing");
  queue.acknowledged(first->size(), 0.2);
  EXPECT_EQ(name(queue.next(0.2)), "image/");
}

TEST(ClientQueue, WhoAcknowledgesNothingGetsLittle) {
  Board board;
  for (int i = 0; i < 2000; ++i) board.put(item("mesh", std::to_string(i), 10'000));
  ClientQueue queue(board);
  for (int i = 0; i < 1000; ++i) {
    board.put(item("poses", "", 500 + static_cast<std::size_t>(i), Haste::live));
    while (queue.next(0.1 * i)) {
    }
  }
  EXPECT_LT(queue.link().under_way(), 100'000u);
  EXPECT_LT(queue.waiting(), 2100u);
  EXPECT_GT(queue.link().silence(100), 99);
}

/// As browsers do: whole messages, those in parts put together.
class Joiner {
 public:
  /// Nothing before the last part.
  std::optional<std::string> take(const Board::Message& message) {
    const std::size_t header = static_cast<unsigned char>((*message)[0]);
    const auto said = nlohmann::json::parse(message->substr(4, header));
    if (said["channel"] != "part") return *message;
    std::string& begun = begun_[said["key"]];
    if (said["at"] == 0) begun.clear();
    EXPECT_EQ(said["at"], begun.size());
    begun += message->substr(4 + header);
    if (said["of"] != begun.size()) return std::nullopt;
    return std::exchange(begun, "");
  }

 private:
  std::map<std::string, std::string> begun_;
};

class ClientQueueOfParts : public ::testing::Test {
 protected:
  /// What has gone out until nothing more goes; acknowledged at a slow link's pace.
  Names rest(int most = 1000) {
    Names names;
    for (int i = 0; i < most; ++i) {
      const auto message = queue_.next(now_);
      if (!message) break;
      bytes_ += message->size();
      queue_.acknowledged(bytes_, now_ += 0.1);
      if (const auto whole = joiner_.take(message)) {
        names.push_back(name(std::make_shared<const std::string>(*whole)) + " " +
                        std::to_string(whole->size() / 1000));
      }
    }
    return names;
  }
  Board board_;
  ClientQueue queue_{board_, true};
  Joiner joiner_;
  std::uint64_t bytes_ = 0;
  double now_ = 0;
};

TEST_F(ClientQueueOfParts, LongMessagesArePutTogetherAgainAndOthersGoInBetween) {
  board_.put(item("mesh", "1", 100'000));
  board_.put(item("image", "", 50'000, Haste::picture));
  EXPECT_EQ(rest(3), Names{});
  board_.put(item("poses", "", 500, Haste::live));
  EXPECT_EQ(rest(), (Names{"poses/ 0", "image/ 50", "mesh/1 100"}));
}

TEST_F(ClientQueueOfParts, WhatChangesOnItsWayArrivesOldAndThenNew) {
  board_.put(item("mesh", "1", 100'000));
  EXPECT_EQ(rest(3), Names{});
  board_.put(item("mesh", "1", 60'000));
  EXPECT_EQ(rest(), (Names{"mesh/1 100", "mesh/1 60"}));
}

TEST_F(ClientQueueOfParts, WhatIsGoneOrUnwantedOnItsWayStops) {
  board_.put(item("mesh", "1", 100'000));
  EXPECT_EQ(rest(3), Names{});
  board_.remove("mesh");
  EXPECT_EQ(rest(), Names{}) << "who never had it need not be told";
  board_.put(item("mesh", "2", 100'000));
  EXPECT_EQ(rest(3), Names{});
  queue_.want({"points"});
  EXPECT_EQ(rest(), Names{});
  queue_.want({"mesh"});
  EXPECT_EQ(rest(), Names{"mesh/2 100"});
  board_.put(item("mesh", "2", 90'000));
  EXPECT_EQ(rest(3), Names{});
  board_.remove("mesh");
  EXPECT_EQ(rest(), Names{"mesh/2 gone 0"});
}

TEST_F(ClientQueueOfParts, OneThatIsBegunIsNotBegunAgain) {
  board_.put(item("mesh", "1", 100'000));
  EXPECT_EQ(rest(3), Names{});
  queue_.want({"mesh"});
  EXPECT_EQ(rest(), Names{"mesh/1 100"});
}

/// A link that carries bytes one after the other, and what its other end says of them.
class Link {
 public:
  Link(double bytes_per_second, double way) : rate_(bytes_per_second), way_(way) {}

  void send(const Board::Message& message, double now) {
    free_ = std::max(free_, now) + static_cast<double>(message->size()) / rate_;
    under_way_.push_back({name(message), message->size(), now, free_ + way_});
  }
  void arrive(ClientQueue& queue, double now) {
    while (!under_way_.empty() && under_way_.front().arrives <= now) {
      const Packet& packet = under_way_.front();
      bytes_ += packet.size;
      acknowledged_.push_back({bytes_, packet.arrives + way_});
      ++messages_[packet.name.substr(0, packet.name.find('/'))];
      if (packet.name == "poses/") {
        longest_way_ = std::max(longest_way_, packet.arrives - packet.sent);
        poses_.push_back(packet.arrives);
      }
      under_way_.pop_front();
    }
    for (; !acknowledged_.empty() && acknowledged_.front().second <= now; acknowledged_.pop_front())
      queue.acknowledged(acknowledged_.front().first, now);
  }
  double longest_way() const { return longest_way_; }
  std::size_t bytes() const { return bytes_; }
  double longest_pause() const {
    double longest = 0;
    for (std::size_t i = 1; i < poses_.size(); ++i) longest = std::max(longest, poses_[i] - poses_[i - 1]);
    return longest;
  }
  std::size_t poses() const { return poses_.size(); }
  int messages(const std::string& channel) const {
    const auto known = messages_.find(channel);
    return known != messages_.end() ? known->second : 0;
  }

 private:
  struct Packet {
    std::string name;
    std::size_t size;
    double sent, arrives;
  };
  double rate_, way_, free_ = 0, longest_way_ = 0;
  std::size_t bytes_ = 0;
  std::deque<Packet> under_way_;
  std::deque<std::pair<std::uint64_t, double>> acknowledged_;
  std::vector<double> poses_;
  std::map<std::string, int> messages_;  // by channel
};

/// 20 MB of maps in items of that size.
Link watched_for(double seconds, Link link, std::size_t size = 20'000, bool parts = false) {
  Board board;
  for (std::size_t i = 0; i < 20'000'000 / size; ++i)
    board.put(item("mesh", std::to_string(i), size, Haste::bulk, 1));
  ClientQueue queue(board, parts);
  for (int step = 0; step < static_cast<int>(seconds / 0.005); ++step) {
    const double now = 0.005 * step;
    if (step % 20 == 0) board.put(item("poses", "", 600 + static_cast<std::size_t>(step), Haste::live));
    if (step % 20 == 0) board.put(item("image", "", 30'000 + static_cast<std::size_t>(step), Haste::picture));
    link.arrive(queue, now);
    while (const auto message = queue.next(now)) link.send(message, now);
  }
  return link;
}

TEST(ClientQueue, ASlowLinkShowsPosesAsTheyAreWhileMapsWait) {
  const Link link = watched_for(30, Link(250'000, 0.1));  // 2 Mbit/s, 200 ms there and back
  EXPECT_GT(link.poses(), 5u * 30);
  EXPECT_LT(link.longest_way(), 1);
  EXPECT_LT(link.longest_pause(), 1);
  EXPECT_GT(static_cast<double>(link.bytes()), 0.8 * 30 * 250'000) << "and the link is used";
}

TEST(ClientQueue, PosesDoNotWaitForLargeMessagesThatGoInParts) {
  const Link link = watched_for(30, Link(250'000, 0.1), 250'000, true);
  EXPECT_GT(link.poses(), 8u * 30);
  EXPECT_LT(link.longest_way(), 0.5);
  EXPECT_LT(link.longest_pause(), 0.3);
  EXPECT_GT(static_cast<double>(link.bytes()), 0.8 * 30 * 250'000);
}

TEST(ClientQueue, WhatChangesFasterThanTheLinkTakesItLeavesHalfOfItToTheRest) {
  Board board;
  for (int i = 0; i < 1000; ++i) board.put(item("mesh", std::to_string(i), 20'000, Haste::bulk, 1));
  ClientQueue queue(board);
  Link link(250'000, 0.1);
  for (int step = 0; step < 6000; ++step) {  // 30 s
    const double now = 0.005 * step;
    if (step % 200 == 0) board.put(item("graph", "", 320'000 + static_cast<std::size_t>(step)));
    link.arrive(queue, now);
    while (const auto message = queue.next(now)) link.send(message, now);
  }
  EXPECT_GT(link.messages("mesh"), 100) << "2 MB of 7.5";
  EXPECT_GE(link.messages("graph"), 8);
}

TEST(ClientQueue, AFastLinkIsUsed) {
  const Link link = watched_for(5, Link(50e6, 0.0005));
  EXPECT_GT(link.bytes(), 20'000'000u) << "all of it has arrived";
  EXPECT_GE(link.poses(), 48u);
}

}  // namespace
}  // namespace lcmslam
