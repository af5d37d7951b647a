// Who asks something quick beside somebody who asks for much.

#include <gmock/gmock.h>

#include <atomic>

#include "procs/map-server/reply_tiles.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

/// Of which number 1 takes until it is let go, and number 2 is about space.
QuestionDesk::Asked asked_at_the_desk(int number, const std::atomic<bool>& let_go) {
  QuestionDesk::Asked asked{{}, parse_question(R"({"ask": "localise", "deadline": 600})"), {}};
  if (number == 2)
    asked.question = parse_question(R"({"ask": "space", "points": [[0, 0, 0]], "deadline": 600})");
  asked.request.request_id = number;
  asked.map.locate = [&let_go] {
    EXPECT_TRUE(testing::wait_for([&] { return let_go.load(); }));
    return AskedMap::Found();
  };
  return asked;
}

TEST(QuestionDesk, WhatIsAskedOfSpaceDoesNotWaitForWhatTakesLong) {
  std::atomic<bool> let_go{false};
  std::vector<std::int64_t> answered;
  QuestionDesk desk(true);
  const auto count = [&] {
    for (const QuestionDesk::Answered& a : desk.take()) answered.push_back(a.request.request_id);
    return answered.size();
  };
  desk.ask(asked_at_the_desk(1, let_go));
  desk.ask(asked_at_the_desk(2, let_go));
  EXPECT_TRUE(testing::wait_for([&] { return count() == 1; }));
  EXPECT_TRUE(desk.busy());
  let_go = true;
  EXPECT_TRUE(testing::wait_for([&] { return count() == 2; }));
  EXPECT_EQ(answered, (std::vector<std::int64_t>{2, 1}));
  EXPECT_FALSE(desk.busy());
}

/// Keeps the numbers of the requests that are answered, tile by tile.
class PacedPublisher : public Publisher {
 public:
  PacedPublisher() : Publisher(1) {}
  std::chrono::microseconds pace() const override { return std::chrono::microseconds(1); }
  std::vector<std::int64_t> answered;

 private:
  void send(const std::string& /*channel*/, const std::vector<std::uint8_t>& bytes,
            Utime /*utime*/) override {
    answered.push_back(decode_message<map_reply_t>(bytes.data(), bytes.size()).request_id);
  }
};

TEST(ReplyTiles, AShortAnswerGoesBeforeTheRestOfALongOne) {
  const auto answer = [](std::int64_t request, std::size_t bytes) {
    QuestionDesk::Answered answered;
    answered.request.request_id = request;
    answered.answer.bytes.resize(bytes);
    return answered;
  };
  PacedPublisher publisher;
  ReplyTiles tiles;
  tiles.add(answer(1, 200'000));
  tiles.add(answer(2, 10));
  while (!tiles.empty()) tiles.send(publisher);
  EXPECT_EQ(publisher.answered, (std::vector<std::int64_t>{2, 1, 1, 1, 1}));
}

}  // namespace
}  // namespace lcmslam
