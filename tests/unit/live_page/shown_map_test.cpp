#include <lcmslam/live_page/shown_map.hpp>

#include <gtest/gtest.h>
#include <algorithm>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

class ShownMapTest : public ::testing::Test {
 protected:
  void add(std::int32_t id, std::size_t points, std::int64_t revision = 1) {
    KeyframeTile tile;
    tile.part.id = id;
    tile.part.revision = revision;
    for (std::size_t i = 0; i < points; ++i) {
      tile.part.cloud.points.emplace_back(random_.uniform(-2, 2), random_.uniform(-2, 2), 1);
      tile.part.cloud.colours.emplace_back(1, 2, 3);
    }
    map_.add(tile);
  }
  std::size_t keyframes() const { return board_.keys("points").size() / point_levels; }
  static std::vector<std::string> told(const Board& board) {
    std::vector<std::string> messages;
    for (const Board::Message& message : board.messages()) messages.push_back(*message);
    std::sort(messages.begin(), messages.end());
    return messages;
  }

  Random random_{1};
  DenseMap map_;
  Board board_;
  ShownMap shown_{board_};
};

TEST_F(ShownMapTest, ALookTakesItsShareAndTheEndIsTheSame) {
  for (std::int32_t id = 0; id < 7; ++id) add(id, 100);
  std::vector<std::size_t> after;
  while (!shown_.clouds(map_, 250)) after.push_back(keyframes());
  EXPECT_EQ(after, (std::vector<std::size_t>{2, 4, 6}));
  Board at_once;
  EXPECT_TRUE(ShownMap(at_once).clouds(map_));
  EXPECT_EQ(told(board_), told(at_once));
  const std::int64_t version = board_.version();
  EXPECT_TRUE(shown_.clouds(map_, 250));
  EXPECT_EQ(board_.version(), version);
}

TEST_F(ShownMapTest, TheNewestComeFirstAndALargeCloudAlone) {
  add(0, 100);
  add(1, 1000);
  EXPECT_FALSE(shown_.clouds(map_, 250));
  EXPECT_EQ(board_.keys("points"), (std::vector<std::string>{"1/0", "1/1", "1/2"}));
  EXPECT_TRUE(shown_.clouds(map_, 250));
  EXPECT_EQ(keyframes(), 2u);
}

TEST_F(ShownMapTest, NothingIsDrawnBetweenTwoLinesOfOneName) {
  const ShownMap::Path first(600, {1, 2, 3}), second(2, {7, 8, 9});
  shown_.paths({{"icp", {&first, nullptr, &second}}});
  EXPECT_EQ(board_.keys("path"), (std::vector<std::string>{"icp/0", "icp/1", "icp/3"}))
      << "the page joins pieces whose numbers follow each other";
}

TEST_F(ShownMapTest, WhatGoesMeanwhileGoesAtOnce) {
  for (std::int32_t id = 0; id < 4; ++id) add(id, 100);
  EXPECT_FALSE(shown_.clouds(map_, 200));
  map_.remove(3);
  add(2, 100, 2);
  EXPECT_FALSE(shown_.clouds(map_, 100));
  EXPECT_EQ(board_.keys("points"), (std::vector<std::string>{"2/0", "2/1", "2/2"}));
}

}  // namespace
}  // namespace lcmslam
