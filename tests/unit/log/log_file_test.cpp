// Reader and writer against each other, against stock LCM and against recordings of others.

#include <gmock/gmock.h>

#include <sys/resource.h>
#include <sys/stat.h>
#include <csignal>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <map>

#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include "tests/support/recordings.hpp"
#include "tests/unit/log/sample_log.hpp"

namespace lcmslam {
namespace {

using testing::Bytes;
using ::testing::HasSubstr;
using testing::make_sample_log;
using testing::SampleLog;
using testing::ScratchFile;

std::vector<LogEvent> read_all(LogReader& reader) {
  std::vector<LogEvent> events;
  while (auto event = reader.next()) events.push_back(std::move(*event));
  return events;
}

void write_all(const std::string& file, const SampleLog& log) {
  LogWriter writer(file);
  for (const auto& e : log.events) writer.write(e.event.timestamp, e.event.channel, e.event.data);
  writer.close();
}

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(LogFile, ReadsBackWhatItWrote) {
  Random random(1);
  const SampleLog log = make_sample_log(random, 500);
  const ScratchFile file;
  write_all(file.path(), log);
  LogReader reader(file.path());
  const auto events = read_all(reader);
  ASSERT_EQ(events.size(), log.events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].number, static_cast<std::int64_t>(i));
    EXPECT_EQ(events[i].timestamp, log.events[i].event.timestamp);
    EXPECT_EQ(events[i].channel, log.events[i].event.channel);
    EXPECT_EQ(events[i].data, log.events[i].event.data);
  }
  EXPECT_TRUE(reader.damages().empty());
  EXPECT_EQ(reader.position(), reader.size());
}

TEST(LogFile, EmptyMessagesAndLongestChannelsPass) {
  const ScratchFile file;
  const std::string channel(999, 'c');
  {
    LogWriter writer(file.path());
    writer.write(-5, channel, {});
    writer.write(0, "A", {});
    EXPECT_THROW(writer.write(0, channel + "c", {}), std::invalid_argument);
    EXPECT_THROW(writer.write(0, "", {}), std::invalid_argument);
    EXPECT_THROW(writer.write(0, std::string_view("a\0b", 3), {}), std::invalid_argument);
    writer.close();
  }
  LogReader reader(file.path());
  const auto events = read_all(reader);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].channel, channel);
  EXPECT_EQ(events[0].timestamp, -5);
  EXPECT_TRUE(events[1].data.empty());
}

TEST(LogFile, StockLcmReadsOurs) {
  Random random(2);
  const SampleLog log = make_sample_log(random, 100);
  const ScratchFile file;
  write_all(file.path(), log);
  lcm::LogFile stock(file.path(), "r");
  ASSERT_TRUE(stock.good());
  for (std::size_t i = 0; i < log.events.size(); ++i) {
    const lcm::LogEvent* event = stock.readNextEvent();
    ASSERT_NE(event, nullptr) << i;
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    EXPECT_EQ(event->eventnum, static_cast<std::int64_t>(i));
    EXPECT_EQ(event->timestamp, log.events[i].event.timestamp);
    EXPECT_EQ(event->channel, log.events[i].event.channel);
    EXPECT_EQ(Bytes(data, data + event->datalen), log.events[i].event.data);
  }
  EXPECT_EQ(stock.readNextEvent(), nullptr);
}

TEST(LogFile, ReadsStockLcmsByteForByteLikeOurs) {
  Random random(3);
  const SampleLog log = make_sample_log(random, 100);
  const ScratchFile ours("ours"), theirs("theirs");
  write_all(ours.path(), log);
  {
    lcm::LogFile stock(theirs.path(), "w");
    ASSERT_TRUE(stock.good());
    for (const auto& e : log.events) {
      Bytes data = e.event.data;
      lcm::LogEvent event;
      event.eventnum = 0;  // LCM counts
      event.timestamp = e.event.timestamp;
      event.channel = e.event.channel;
      event.datalen = static_cast<int>(data.size());
      event.data = data.data();
      ASSERT_EQ(stock.writeEvent(&event), 0);
    }
  }
  const auto content = [](const ScratchFile& file) {
    std::ostringstream text;
    text << std::ifstream(file.path(), std::ios::binary).rdbuf();
    return text.str();
  };
  EXPECT_EQ(content(ours), content(theirs));
}

TEST(LogFile, SeeksAndRewinds) {
  Random random(4);
  const SampleLog log = make_sample_log(random, 50);
  LogReader reader(log.bytes.data(), log.bytes.size());
  reader.seek(log.events[20].event.timestamp - 1);
  EXPECT_EQ(reader.next()->number, log.events[20].event.number);
  reader.seek(log.events[49].event.timestamp + 1);
  EXPECT_FALSE(reader.next());
  reader.rewind();
  EXPECT_EQ(read_all(reader).size(), 50U);
}

TEST(LogFile, DamageIsListedOnceHoweverOftenItIsPassed) {
  Random random(5);
  const SampleLog log = make_sample_log(random, 50);
  Bytes bytes = log.bytes;
  bytes[log.events[10].begin] ^= 1;
  bytes.resize(bytes.size() - 3);
  LogReader reader(bytes.data(), bytes.size());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(read_all(reader).size(), 48U);
    EXPECT_EQ(reader.damages().size(), 2U);
    reader.seek(log.events[5].event.timestamp);
    EXPECT_EQ(reader.next()->number, log.events[5].event.number);
    reader.rewind();
  }
  EXPECT_THAT(reader.damages()[1].reason, HasSubstr("the file ends after"));
}

TEST(LogFile, EventsInsideAMessageAreItsPayload) {
  Random random(6);
  const SampleLog inner = make_sample_log(random, 5);
  Bytes bytes;
  for (int i = 0; i < 20; ++i)
    testing::append_event(bytes,
                          {i, 1000 * i, i % 3 == 0 ? "FILE" : "OTHER", i % 3 == 0 ? inner.bytes : Bytes(9)});
  LogReader reader(bytes.data(), bytes.size());
  EXPECT_EQ(read_all(reader).size(), 20U);
  EXPECT_TRUE(reader.damages().empty());
}

TEST(LogFile, WhatIsNoLogIsNamedSo) {
  const ScratchFile file("notes.txt");
  EXPECT_THAT(error_of([&] { LogReader reader(file.path()); }),
              AllOf(HasSubstr(file.path()), HasSubstr("No such file")));
  EXPECT_THAT(error_of([&] { LogReader reader(file.folder()); }), HasSubstr("is a folder"));
  EXPECT_THAT(error_of([&] { LogReader reader("/dev/null"); }), HasSubstr("not a regular file"));
  const std::string pipe = file.path() + ".pipe";  // nobody writes to it: it must not be waited for
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(error_of([&] { LogReader reader(pipe); }), HasSubstr("not a regular file"));
  file.write({});
  EXPECT_THAT(error_of([&] { LogReader reader(file.path()); }),
              AllOf(HasSubstr(file.path()), HasSubstr("is empty")));
  file.write(Bytes(100'000, 'x'));
  EXPECT_THAT(error_of([&] { LogReader reader(file.path()); }),
              AllOf(HasSubstr(file.path()), HasSubstr("is no LCM log")));
}

TEST(LogWriter, ALinkIsNeitherFollowedNorReplaced) {
  const ScratchFile file;
  const std::string link = file.path() + ".link";
  std::filesystem::create_symlink(file.path(), link);
  EXPECT_THAT(error_of([&] { LogWriter writer(link); }),
              HasSubstr(link + ": cannot be written: is a symbolic link"));
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_FALSE(std::filesystem::exists(file.path()));
}

TEST(LogWriter, LeavesNothingWhenItIsNotClosed) {
  const ScratchFile file;
  {
    LogWriter writer(file.path());
    writer.write(1, "A", Bytes(10));
    EXPECT_FALSE(std::filesystem::exists(file.path()));
  }
  EXPECT_TRUE(std::filesystem::is_empty(file.folder()));
  EXPECT_THAT(error_of([&] { LogWriter writer(file.path() + "/no/folder"); }),
              HasSubstr("/no/folder: cannot be written"));
}

/// A limit of the file's size is what a full disk looks like.
TEST(LogWriter, FullDiskIsAnErrorThatNamesTheFile) {
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  getrlimit(RLIMIT_FSIZE, &old);
  rlimit small = old;
  small.rlim_cur = 300'000;
  setrlimit(RLIMIT_FSIZE, &small);
  const ScratchFile file;
  const auto write = [&](int events) {
    LogWriter writer(file.path());
    for (int i = 0; i < events; ++i) writer.write(i, "A", Bytes(10'000));
    writer.close();
  };
  const std::string in_time = error_of([&] { write(20); });
  const std::string at_close = error_of([&] { write(40); });  // still in the buffer until then
  const std::string at_write = error_of([&] { write(10'000); });
  setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_EQ(in_time, "");
  EXPECT_THAT(at_close, HasSubstr(file.path() + ": cannot be written: "));
  EXPECT_THAT(at_write, HasSubstr(file.path() + ": cannot be written: "));
  EXPECT_EQ(std::filesystem::file_size(file.path()), 20U * (10'000 + 29));  // the whole one
}

class Recording : public ::testing::TestWithParam<std::pair<const char*, std::map<std::string, int>>> {};

/// Counts from the recordings' ORIGIN.md, order and content as stock LCM reads them.
TEST_P(Recording, ReadsLikeStockLcm) {
  const auto [name, expected] = GetParam();
  LCMSLAM_SKIP_WITHOUT(name);
  const std::string file = recording_path(name);
  LogReader reader(file);
  lcm::LogFile stock(file, "r");
  std::map<std::string, int> counts;
  while (const auto event = reader.next_view()) {
    ++counts[std::string(event->channel)];
    const lcm::LogEvent* other = stock.readNextEvent();
    ASSERT_NE(other, nullptr);
    const auto* data = static_cast<const std::uint8_t*>(other->data);
    EXPECT_EQ(event->number, other->eventnum);
    EXPECT_EQ(event->timestamp, other->timestamp);
    EXPECT_EQ(event->channel, other->channel);
    EXPECT_EQ(event->copy().data, Bytes(data, data + other->datalen));
  }
  EXPECT_EQ(stock.readNextEvent(), nullptr);
  EXPECT_EQ(counts, expected);
  EXPECT_TRUE(reader.damages().empty());
}

using Counts = std::map<std::string, int>;
INSTANTIATE_TEST_SUITE_P(
    Foreign, Recording,
    ::testing::Values(std::pair("lcmlog_small/lcm-proj-example.lcmlog", Counts{{"JOINT_TEST", 10}}),
                      std::pair("lcmlog_small/lcmlog-export-test.00", Counts{{"EXAMPLE", 1}}),
                      std::pair("lcmlog_maebot_convex/convex.log", Counts{{"MAEBOT_ENCODERS", 3422},
                                                                          {"MAEBOT_IMU", 1376},
                                                                          {"RPLIDAR_LASER", 459},
                                                                          {"SLAM_POSE", 457}})));

}  // namespace
}  // namespace lcmslam
