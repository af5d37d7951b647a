// Logs damaged at random places: what the damage did not touch comes back, all of it and only it.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include <lcmslam/log/log_reader.hpp>
#include "tests/unit/log/sample_log.hpp"

namespace lcmslam {
namespace {

using testing::append_event;
using testing::Bytes;
using testing::draw;
using testing::make_sample_log;
using testing::SampleEvent;
using testing::SampleLog;

constexpr int seeds = 8000;

/// A damaged log and the events that still stand in it byte for byte.
struct Damaged {
  Bytes bytes;
  std::vector<const SampleEvent*> intact;
  std::set<std::int64_t> header_touched;  // numbers
};

std::size_t find_event(const SampleLog& log, std::size_t offset) {
  std::size_t i = 0;
  while (i + 1 < log.events.size() && log.events[i].end <= offset) ++i;
  return i;
}

Damaged replace(const SampleLog& log, std::size_t begin, std::size_t end, const Bytes& with) {
  Damaged damaged;
  const auto at = [&](std::size_t i) { return log.bytes.begin() + static_cast<std::ptrdiff_t>(i); };
  damaged.bytes.assign(log.bytes.begin(), at(begin));
  damaged.bytes.insert(damaged.bytes.end(), with.begin(), with.end());
  damaged.bytes.insert(damaged.bytes.end(), at(end), log.bytes.end());
  const bool in_place = with.size() == end - begin;
  for (const SampleEvent& e : log.events) {
    bool touched = begin < e.end && end > e.begin;
    if (in_place && touched)  // bytes may be replaced by the same
      touched =
          !std::equal(at(e.begin), at(e.end), damaged.bytes.begin() + static_cast<std::ptrdiff_t>(e.begin));
    if (begin == end) touched = e.begin < begin && begin < e.end;
    if (!touched) damaged.intact.push_back(&e);
    if (touched && begin < e.begin + 20) damaged.header_touched.insert(e.event.number);
  }
  return damaged;
}

Bytes noise(Random& random, std::size_t n) {
  Bytes bytes(n);
  const bool zeros = draw(random, 4) == 0;  // what file systems leave
  for (auto& byte : bytes) byte = zeros ? 0 : static_cast<std::uint8_t>(draw(random, 256));
  return bytes;
}

using Damager = Damaged (*)(const SampleLog&, Random&);

Damaged flip_bit(const SampleLog& log, Random& random) {
  const std::size_t at = draw(random, log.bytes.size());
  return replace(log, at, at + 1, {static_cast<std::uint8_t>(log.bytes[at] ^ (1U << draw(random, 8)))});
}
Damaged flip_header_bit(const SampleLog& log, Random& random) {
  const std::size_t at = log.events[draw(random, log.events.size())].begin + draw(random, 28);
  return replace(log, at, at + 1, {static_cast<std::uint8_t>(log.bytes[at] ^ (1U << draw(random, 8)))});
}
Damaged overwrite(const SampleLog& log, Random& random) {
  const std::size_t begin = draw(random, log.bytes.size());
  const std::size_t n = std::min(1 + draw(random, 600), log.bytes.size() - begin);
  return replace(log, begin, begin + n, noise(random, n));
}
Damaged cut_out(const SampleLog& log, Random& random) {
  const std::size_t begin = draw(random, log.bytes.size());
  return replace(log, begin, std::min(begin + 1 + draw(random, 600), log.bytes.size()), {});
}
Damaged insert(const SampleLog& log, Random& random) {
  std::size_t at = draw(random, log.bytes.size() + 1);
  if (draw(random, 4) == 0) at = log.events[find_event(log, at)].begin;  // between two events
  return replace(log, at, at, noise(random, 1 + draw(random, 64)));
}
Damaged truncate(const SampleLog& log, Random& random) {
  return replace(log, 1 + draw(random, log.bytes.size() - 1), log.bytes.size(), {});
}
Damaged set_length(const SampleLog& log, Random& random) {
  const std::uint8_t extremes[][4] = {{0x7f, 0xff, 0xff, 0xff},
                                      {0xff, 0xff, 0xff, 0xff},
                                      {0x80, 0, 0, 0},
                                      {0x10, 0, 0, 0},
                                      {0, 0, 0, 0},
                                      {0, 0, 1, 0}};
  const auto& value = extremes[draw(random, std::size(extremes))];
  const std::size_t at = log.events[draw(random, log.events.size())].begin + (draw(random, 4) == 0 ? 20 : 24);
  return replace(log, at, at + 4, Bytes(value, value + 4));
}

struct Read {
  std::vector<LogEvent> events;
  std::vector<LogDamage> damages;
};

Read read(const Bytes& bytes, WholenessCheck check) {
  LogReader reader(bytes.data(), bytes.size(), std::move(check));
  Read result;
  std::uint64_t tiled = 0;
  while (auto event = reader.next_view()) {
    tiled += log_format::header_size + event->channel.size() + event->size;
    result.events.push_back(event->copy());
  }
  result.damages = reader.damages();
  for (const auto& damage : result.damages) {
    EXPECT_LT(damage.begin, damage.end);
    EXPECT_FALSE(damage.reason.empty());
    tiled += damage.end - damage.begin;
  }
  EXPECT_EQ(tiled, bytes.size()) << "events and damages must cover the file, once";
  return result;
}

bool same(const LogEvent& a, const LogEvent& b) {
  return a.number == b.number && a.timestamp == b.timestamp && a.channel == b.channel && a.data == b.data;
}

/// How many of the intact events came back, in order, each once; the others that came are in `others`.
std::size_t count_recovered(const Damaged& damaged, const Read& result, std::vector<LogEvent>& others) {
  std::size_t recovered = 0;
  for (const LogEvent& event : result.events) {
    if (recovered < damaged.intact.size() && same(event, damaged.intact[recovered]->event))
      ++recovered;
    else
      others.push_back(event);
  }
  return recovered;
}

// A log in a message whose neighbours' numbers fit nothing: from each of its events the way to the end was
// walked, a quarter of an hour here.
TEST(CraftedLog, IsReadInTheTimeThatItsSizeTakes) {
  constexpr int inside = 600'000;
  LogEvent outer{1, 0, "A", {}};
  for (int i = 0; i < inside; ++i) append_event(outer.data, {1000 + i, 0, "B", {}});
  Bytes bytes;
  for (const LogEvent& event :
       {LogEvent{0, 0, "A", {}}, outer, LogEvent{5, 0, "A", {}}, LogEvent{6, 0, "A", {}}})
    append_event(bytes, event);
  const Read result = read(bytes, {});
  ASSERT_EQ(result.events.size(), 4U);
  EXPECT_EQ(result.events[1].data.size(), outer.data.size());
  bytes.resize(bytes.size() - 200);  // nor where it has no end
  EXPECT_FALSE(read(bytes, {}).events.empty());
}

class Damage : public ::testing::TestWithParam<Damager> {};

TEST_P(Damage, RecoversEveryEventThatItDidNotTouch) {
  for (int seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(static_cast<std::uint64_t>(seed));
    const SampleLog log = make_sample_log(random, 2 + static_cast<int>(draw(random, 30)));
    const Damaged damaged = GetParam()(log, random);
    std::vector<LogEvent> others;
    ASSERT_EQ(count_recovered(damaged, read(damaged.bytes, nullptr), others), damaged.intact.size());
    ASSERT_LE(others.size(), 1U);  // without knowledge of the messages a damaged one may pass
  }
}

TEST_P(Damage, NoDamagedMessagePassesWhereMessagesCanBeChecked) {
  for (int seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(static_cast<std::uint64_t>(seed));
    const SampleLog log = make_sample_log(random, 2 + static_cast<int>(draw(random, 30)));
    const Damaged damaged = GetParam()(log, random);
    const Read result = read(damaged.bytes, testing::check_sum);
    std::vector<LogEvent> others;
    ASSERT_EQ(count_recovered(damaged, result, others), damaged.intact.size());
    for (const LogEvent& event : others) {
      // Only what a message's own checksum cannot tell: its number and its time.
      const bool explained =
          std::any_of(log.events.begin(), log.events.end(), [&](const SampleEvent& original) {
            return original.event.channel == event.channel && original.event.data == event.data &&
                   (same(original.event, event) || damaged.header_touched.count(original.event.number) > 0);
          });
      ASSERT_TRUE(explained) << event.number;
    }
  }
}

std::string damager_name(const ::testing::TestParamInfo<Damager>& info) {
  const char* const names[] = {"FlippedBit", "FlippedHeaderBit", "Overwritten", "CutOut",
                               "Inserted",   "Truncated",        "Length"};
  return names[info.index];
}

INSTANTIATE_TEST_SUITE_P(Each, Damage,
                         ::testing::Values(flip_bit, flip_header_bit, overwrite, cut_out, insert, truncate,
                                           set_length),
                         damager_name);

TEST(DamageCount, NumbersAroundItTellHowManyEventsItTook) {
  Random random(3);
  const SampleLog log = make_sample_log(random, 20);
  // From the middle of event 5 to the middle of event 8, then a message of event 12.
  const std::size_t begin = log.events[5].begin + 30, end = log.events[8].begin + 30;
  Bytes bytes = replace(log, begin, end, Bytes(end - begin, 0)).bytes;
  bytes[log.events[12].end - 1] ^= 1;
  const Read result = read(bytes, testing::check_sum);
  EXPECT_EQ(result.events.size(), 15U);
  ASSERT_EQ(result.damages.size(), 2U);
  EXPECT_EQ(result.damages[0].begin, log.events[5].begin);
  EXPECT_EQ(result.damages[0].end, log.events[9].begin);
  EXPECT_EQ(result.damages[0].lost, 4);
  EXPECT_EQ(result.damages[1].begin, log.events[12].begin);
  EXPECT_EQ(result.damages[1].lost, 1);
}

TEST(DamageCount, OneStretchIsOneDamage) {
  Random random(3);
  const SampleLog log = make_sample_log(random, 6);
  // Two sync words with nothing behind them, where event 3 stood.
  const SampleEvent &lost = log.events[3], &next = log.events[4];
  Bytes nothing(lost.end - lost.begin, 0);
  for (const std::size_t at : {std::size_t{0}, nothing.size() / 2}) {
    const std::uint8_t sync[] = {0xED, 0xA1, 0xDA, 0x01};
    std::copy(std::begin(sync), std::end(sync), nothing.begin() + static_cast<std::ptrdiff_t>(at));
  }
  const Read result = read(replace(log, lost.begin, lost.end, nothing).bytes, testing::check_sum);
  EXPECT_EQ(result.events.size(), 5U);
  ASSERT_EQ(result.damages.size(), 1U);
  EXPECT_EQ(result.damages[0].begin, lost.begin);
  EXPECT_EQ(result.damages[0].end, next.begin);
  EXPECT_EQ(result.damages[0].lost, 1);
}

TEST(DamageCount, ANumberThatFitsNeitherNeighbourIsDamage) {
  Random random(5);
  const SampleLog log = make_sample_log(random, 9);
  Bytes bytes = log.bytes;
  bytes[log.events[4].begin + 4 + 2] ^= 0x10;  // of its number
  const Read result = read(bytes, {});         // nobody knows the messages
  EXPECT_EQ(result.events.size(), 8U);
  ASSERT_EQ(result.damages.size(), 1U);
  EXPECT_EQ(result.damages[0].begin, log.events[4].begin);
  EXPECT_EQ(result.damages[0].end, log.events[5].begin);
  EXPECT_NE(result.damages[0].reason.find("fits neither neighbour"), std::string::npos)
      << result.damages[0].reason;
}

TEST(DamageCount, ManyDamagesLeaveTheRest) {
  for (int seed = 0; seed < 200; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const SampleLog log = make_sample_log(random, 200);
    Bytes bytes = log.bytes;
    std::set<std::size_t> touched;
    for (int i = 0; i < 10; ++i) {
      const std::size_t at = draw(random, bytes.size());
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1U << draw(random, 8)));
      touched.insert(find_event(log, at));
    }
    Damaged damaged;
    for (std::size_t i = 0; i < log.events.size(); ++i)
      if (touched.count(i) == 0) damaged.intact.push_back(&log.events[i]);
    std::vector<LogEvent> others;
    EXPECT_EQ(count_recovered(damaged, read(bytes, testing::check_sum), others), damaged.intact.size())
        << "seed " << seed;
    EXPECT_LE(others.size(), touched.size());
  }
}

}  // namespace
}  // namespace lcmslam
