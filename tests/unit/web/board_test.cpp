#include <lcmslam/web/board.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

BoardItem item(const std::string& channel, const std::string& key, const std::string& payload,
               int urgency = 0) {
  return {channel, key, R"({"n":1})", std::make_shared<const std::string>(payload), Haste::bulk, urgency, {}};
}

std::string payload(const Board::Message& message) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(message->data());
  const std::size_t header =
      bytes[0] | static_cast<std::size_t>(bytes[1]) << 8 | static_cast<std::size_t>(bytes[2]) << 16;
  EXPECT_EQ(header % 4, 0u);
  return message->substr(4 + header);
}

std::string header(const Board::Message& message) {
  const std::string text = message->substr(4, message->size() - 4 - payload(message).size());
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

TEST(Board, AMessageHasItsNameItsHeaderAndItsPayload) {
  Board board;
  board.put(item("points", "3/0", "abc"));
  const auto messages = board.messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(header(messages[0]), R"({"channel":"points","key":"3/0","n":1})");
  EXPECT_EQ(payload(messages[0]), "abc");
}

TEST(Board, KeysAreWrittenAsJsonHasThem) {
  Board board;
  board.put({"points", "a\"b\\", "{}", nullptr, Haste::bulk, 0, {}});
  EXPECT_EQ(header(board.messages()[0]), R"({"channel":"points","key":"a\"b\\"})");
}

TEST(Board, TheNewestOfANameTakesThePlaceOfTheOneBefore) {
  Board board;
  board.put(item("points", "1", "old"));
  board.put(item("points", "2", "other"));
  board.put(item("points", "1", "new"));
  const auto changed = board.changed(0);
  ASSERT_EQ(changed.size(), 2u);
  EXPECT_EQ(payload(changed[0]->message), "other");
  EXPECT_EQ(payload(changed[1]->message), "new");
  EXPECT_EQ(changed[1]->version, board.version());
}

TEST(Board, WhatSaysTheSameIsNoChange) {
  Board board;
  board.put(item("points", "1", "same"));
  const auto version = board.version();
  board.put(item("points", "1", "same"));
  EXPECT_EQ(board.version(), version);
  EXPECT_TRUE(board.changed(version).empty());
}

TEST(Board, WhatIsGoneIsSaidOnceAndMayComeBack) {
  Board board;
  board.put(item("points", "1", "a"));
  board.put(item("points", "2", "b"));
  board.put(item("mesh", "1", "c"));
  const auto before = board.version();
  board.remove("points");
  board.remove("points", "1");
  const auto changed = board.changed(before);
  ASSERT_EQ(changed.size(), 2u);
  EXPECT_TRUE(changed[0]->gone);
  EXPECT_EQ(header(changed[0]->message), R"({"channel":"points","key":"1","gone":true})");
  EXPECT_EQ(board.messages().size(), 1u);
  EXPECT_TRUE(board.keys("points").empty());
  board.put(item("points", "1", "a"));
  EXPECT_EQ(board.keys("points"), std::vector<std::string>{"1"});
}

TEST(Board, UrgentMessagesComeFirst) {
  Board board;
  board.put(item("a", "", "late", 3));
  board.put(item("b", "", "soon", 1));
  EXPECT_EQ(payload(board.messages()[0]), "soon");
}

TEST(Board, WhatIsLongGoneIsForgotten) {
  Board board;
  for (int i = 0; i < 30'000; ++i) {
    board.put(item("points", std::to_string(i), "x"));
    board.remove("points", std::to_string(i));
  }
  EXPECT_EQ(board.changed(0).size(), 20'000u);
}

}  // namespace
}  // namespace lcmslam
