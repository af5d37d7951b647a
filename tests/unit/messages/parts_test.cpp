// Messages in pieces, and back.

#include <gmock/gmock.h>

#include <algorithm>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/parts.hpp>

namespace lcmslam {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes some_bytes(std::size_t size, std::uint64_t seed) {
  Random random(seed);
  Bytes bytes(size);
  for (auto& b : bytes) b = static_cast<std::uint8_t>(random.uniform(0, 256));
  return bytes;
}

TEST(Parts, ChannelsAreToldApart) {
  EXPECT_EQ(part_channel("CAMERA"), "CAMERA_PART");
  EXPECT_TRUE(is_part_channel("CAMERA_PART"));
  EXPECT_FALSE(is_part_channel("CAMERA"));
  EXPECT_FALSE(is_part_channel("_PART"));
}

TEST(Parts, EverySizeComesBackInAnyOrder) {
  for (const std::size_t size : {1U, 99U, 100U, 101U, 200U, 1234U}) {
    SCOPED_TRACE(size);
    const Bytes bytes = some_bytes(size, size);
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      auto parts = split_message("X", bytes, 77, 3, 100);
      EXPECT_EQ(parts.size(), (size + 99) / 100);
      Random random(seed);
      for (std::size_t i = parts.size(); i > 1; --i)
        std::swap(parts[i - 1], parts[static_cast<std::size_t>(random.uniform(0, static_cast<double>(i)))]);
      PartAssembler assembler;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto whole = assembler.add(parts[i]);
        ASSERT_EQ(whole.has_value(), i + 1 == parts.size());
        if (!whole) continue;
        EXPECT_EQ(whole->channel, "X");
        EXPECT_EQ(whole->utime, 77);
        EXPECT_EQ(whole->bytes, bytes);
      }
    }
  }
}

TEST(Parts, SendersAndChannelsDoNotMixAndTwicePiecesDoNoHarm) {
  const Bytes a = some_bytes(250, 1), b = some_bytes(250, 2), c = some_bytes(250, 3);
  auto of_a = split_message("X", a, 1, 0, 100);
  auto of_b = split_message("X", b, 1, 0, 100);
  auto of_c = split_message("Y", c, 1, 0, 100);
  for (auto& part : of_b) part.sender = 9;
  PartAssembler assembler;
  std::vector<Bytes> wholes;
  for (std::size_t i = 0; i < 3; ++i)
    for (const auto* part : {&of_a[i], &of_b[i], &of_c[i], &of_a[i]}) {
      if (i == 2 && part == &of_a[i] && wholes.size() == 3) break;  // it would begin the message anew
      if (auto whole = assembler.add(*part)) wholes.push_back(whole->bytes);
    }
  EXPECT_THAT(wholes, ::testing::ElementsAre(a, b, c));
}

TEST(Parts, AMissingPieceCostsItsMessageAndIsCounted) {
  PartAssembler assembler;
  int wholes = 0;
  for (std::int64_t message = 0; message < 50; ++message)
    for (const auto& part : split_message("X", some_bytes(250, 1), 1, message, 100))
      if (message % 5 != 2 || part.part != 1) wholes += assembler.add(part) ? 1 : 0;
  EXPECT_EQ(wholes, 40);
  EXPECT_EQ(assembler.incomplete(), 10);
}

TEST(Parts, SendersThatGoAwayLeaveNoMoreThanEightMessages) {
  PartAssembler assembler;
  for (int sender = 1; sender <= 20; ++sender) {
    part_t first = split_message("X", some_bytes(250, 1), 1, 0, 100).front();
    first.sender = sender;
    EXPECT_FALSE(assembler.add(first));
  }
  EXPECT_EQ(assembler.incomplete(), 12);
}

TEST(Parts, HalfMessagesAreBoundedAndTheNewestStillComes) {
  constexpr std::size_t bound = 32 << 20, size = 15 << 20;
  const Bytes bytes(size, 7);
  auto parts = split_message("X", bytes, 1, 0, 1 << 20);
  PartAssembler assembler;
  for (std::int64_t sender = 1; sender <= 6; ++sender)
    for (part_t& part : parts) {
      part.sender = sender;
      if (part.part == 14) continue;
      EXPECT_FALSE(assembler.add(part));
      EXPECT_LE(assembler.waiting_bytes(), bound);
    }
  EXPECT_EQ(assembler.incomplete(), 4);
  const auto whole = assembler.add(parts.back());
  ASSERT_TRUE(whole);
  EXPECT_TRUE(whole->bytes == bytes);
  EXPECT_LT(assembler.waiting_bytes(), size);
}

TEST(Parts, SmallPiecesCountWithWhatItTakesToKeepThem) {
  part_t part = split_message("X", Bytes{1}, 1, 0, 1).front();
  part.n_parts = part.total_size = 1 << 20;
  PartAssembler assembler;
  std::size_t most = 0;
  for (part.part = 0; part.part < 300'000; ++part.part) {
    assembler.add(part);
    most = std::max(most, assembler.waiting_bytes());
  }
  EXPECT_LE(most, std::size_t{32} << 20);
  EXPECT_EQ(assembler.incomplete(), 1);
}

TEST(Parts, MoreBytesThanTheMessageHasAreNotKept) {
  auto parts = split_message("X", some_bytes(250, 1), 1, 0, 100);
  PartAssembler assembler;
  assembler.add(parts[0]);
  part_t swollen = parts[1];
  swollen.data.resize(151);
  swollen.size = 151;
  EXPECT_THROW(assembler.add(swollen), DecodeError);
  assembler.add(parts[1]);
  const auto whole = assembler.add(parts[2]);
  ASSERT_TRUE(whole) << "the message's own pieces still make it whole";
  EXPECT_EQ(whole->bytes, some_bytes(250, 1));
}

TEST(Parts, ContradictionsAreRefused) {
  const auto good = split_message("X", some_bytes(250, 1), 1, 0, 100);
  const auto refused = [&](auto change) {
    part_t bad = good[1];
    change(bad);
    PartAssembler assembler;
    assembler.add(good[0]);
    EXPECT_THROW(assembler.add(bad), DecodeError);
  };
  refused([](part_t& p) { p.n_parts = 0; });
  refused([](part_t& p) { p.n_parts = 4; });
  refused([](part_t& p) { p.part = 3; });
  refused([](part_t& p) { p.part = -1; });
  refused([](part_t& p) { p.total_size = -1; });
  refused([](part_t& p) { p.total_size = 2'000'000'000; });
  refused([](part_t& p) { p.total_size = 251; });
  PartAssembler().add(split_message("X", Bytes(32 << 20), 1, 0, 1 << 20).front());
  EXPECT_THROW(PartAssembler().add(split_message("X", Bytes((32 << 20) + 1), 1, 0, 1 << 20).front()),
               DecodeError);
  PartAssembler(250).add(good[0]);
  EXPECT_THROW(PartAssembler(249).add(good[0]), DecodeError);
  PartAssembler().add(split_message(std::string(63, 'X'), Bytes(250), 1, 0, 100).front());
  EXPECT_THROW(PartAssembler().add(split_message(std::string(64, 'X'), Bytes(250), 1, 0, 100).front()),
               DecodeError);
  refused([](part_t& p) { p.size = 0; });
  refused([](part_t& p) { p.channel = ""; });
  refused([](part_t& p) { p.channel = "X_PART"; });
  part_t short_piece = good[1];
  short_piece.data.pop_back();
  --short_piece.size;
  PartAssembler assembler;
  assembler.add(good[0]);
  assembler.add(short_piece);
  EXPECT_THROW(assembler.add(good[2]), DecodeError);
  EXPECT_THROW(split_message("X", some_bytes(1, 1), 0, 0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
