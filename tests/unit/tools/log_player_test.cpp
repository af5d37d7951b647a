#include "tools/log/log_player.hpp"

#include <gmock/gmock.h>

#include <lcmslam/features_t.hpp>
#include <lcmslam/twist_t.hpp>

#include "tests/unit/tools/log_samples.hpp"
#include "tools/log/message_facts.hpp"

namespace lcmslam {
namespace {

using namespace testing;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A bus whose time passes only while the player waits, with mappers on it: each needs odometry at the
/// frame's time, works for a while, and takes one frame at a time (one that comes while it works is dropped).
class SimulatedBus : public PlayBus {
 public:
  struct Mapper {
    std::string channel;
    milliseconds work{30};
    std::int64_t dropped = 0, done = 0;
    bool dead = false;
    std::optional<Utime> frame = std::nullopt;  // at work, or waits for odometry
    std::optional<Time> ready = std::nullopt;   // when its answer comes
  };
  std::vector<Mapper> mappers;
  std::string frames = "CAMERA", readings = "ENCODERS";
  std::vector<std::pair<std::string, Time>> sent;
  std::size_t stop_after = SIZE_MAX;

  Time now() override { return now_; }
  bool stopped() override { return sent.size() >= stop_after; }
  void send(const std::string& channel, const std::vector<std::uint8_t>&, Utime utime) override {
    sent.emplace_back(channel, now_);
    if (channel == readings) odometry_ = utime;
    for (Mapper& mapper : mappers) {
      if (channel == frames) {
        mapper.dropped += mapper.frame ? 1 : 0;
        if (!mapper.frame) mapper.frame = utime;
      }
      if (mapper.frame && !mapper.ready && odometry_ >= *mapper.frame) mapper.ready = now_ + mapper.work;
    }
  }
  void wait_until(Time time) override {
    Mapper* next = nullptr;
    for (Mapper& mapper : mappers)
      if (mapper.ready && !mapper.dead && (next == nullptr || *mapper.ready < *next->ready)) next = &mapper;
    if (next == nullptr || *next->ready > time) {
      now_ = std::max(now_, time);
      return;
    }
    now_ = std::max(now_, *next->ready);
    const Utime frame = *next->frame;
    next->frame.reset();
    next->ready.reset();
    ++next->done;
    if (on_answer) on_answer(next->channel, frame);
  }

 private:
  Time now_ = Time() + std::chrono::hours(1);
  Utime odometry_ = 0;
};

class LogPlayer : public ::testing::Test {
 protected:
  static std::size_t count(const SimulatedBus& bus, const std::string& channel) {
    std::size_t n = 0;
    for (const auto& [name, time] : bus.sent) n += name == channel ? 1 : 0;
    return n;
  }
  ScratchFolder folder_;
  SimulatedBus bus_;
  PlaySettings settings_;
};

TEST_F(LogPlayer, KeepsTheRecordedIntervals) {
  const std::string file = sample_log(folder_, 3);
  settings_.all_channels = true;
  for (const double speed : {1.0, 2.0}) {
    SimulatedBus bus;
    settings_.speed = speed;
    const PlayCounts counts = play_log(file, settings_, bus);
    const auto events = read_log(file);
    ASSERT_EQ(bus.sent.size(), events.size());
    for (std::size_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(bus.sent[i].first, events[i].channel);
      const double logged = 1e-6 * static_cast<double>(events[i].timestamp - events[0].timestamp);
      const double played = std::chrono::duration<double>(bus.sent[i].second - bus.sent[0].second).count();
      EXPECT_NEAR(played, logged / speed, 1e-6);
    }
    EXPECT_EQ(counts.frames, 30);
    EXPECT_NEAR(counts.log_seconds, 2.98, 1e-6);
    EXPECT_NEAR(counts.seconds, 2.98 / speed, 1e-6);
  }
}

TEST_F(LogPlayer, ADamagedTimeIsNotWaitedFor) {
  const std::string file = (folder_.path() / "leap.lcmlog").string();
  LogWriter log(file);
  for (int i = 0; i < 50; ++i)
    log.write(sample_start + i * 20'000 + (i == 20 ? Utime{1} << 45 : 0), "X", Bytes(9));
  log.close();
  const PlayCounts counts = play_log(file, settings_, bus_);
  EXPECT_EQ(counts.messages, 50);
  EXPECT_NEAR(counts.seconds, 0.94, 0.05);
}

TEST_F(LogPlayer, LeavesOutWhatTheGraphComputesAndWhatIsTold) {
  settings_.processes = {"surf", "odometry", "fastslam", "icp", "map-server"};
  const std::set<std::string> ours{"CAMERA", "ENCODERS", "ICP_POSE", "STATUS"}, foreign{"POSE", "SCAN"};
  EXPECT_THAT(channels_to_play(ours, settings_), ElementsAre("CAMERA", "ENCODERS"));
  EXPECT_EQ(channels_to_play(foreign, settings_), foreign);
  settings_.all_channels = true;
  EXPECT_EQ(channels_to_play(ours, settings_), ours);
  settings_.answer_channels = {"ICP_POSE"};  // the recorded answers must not be taken for live ones
  EXPECT_THAT(channels_to_play(ours, settings_), ElementsAre("CAMERA", "ENCODERS"));
  settings_.selection.channels = {"STATUS", "ENCODERS"};
  settings_.answer_channels.clear();
  EXPECT_THAT(channels_to_play(ours, settings_), ElementsAre("ENCODERS", "STATUS"));
}

TEST_F(LogPlayer, PlaysWhateverOdometryMayBeMadeOf) {
  settings_.processes = {"surf", "odometry", "fastslam", "icp", "map-server"};
  EXPECT_THAT(channels_to_play({"CAMERA", "FEATURES", "ODOMETRY", "POSE_BODY", "SCAN", "TWIST"}, settings_),
              ElementsAre("CAMERA", "POSE_BODY", "SCAN", "TWIST"));
}

TEST_F(LogPlayer, PlaysWhatTheGraphCannotCompute) {
  const std::set<std::string> landmarks{"FASTSLAM_POSE", "FEATURES", "GROUND_TRUTH", "ODOMETRY", "TWIST"};
  settings_.processes = {"surf", "odometry", "fastslam", "icp",
                         "map-server"};  // no images: surf makes nothing
  EXPECT_THAT(channels_to_play(landmarks, settings_), ElementsAre("FEATURES", "GROUND_TRUTH", "TWIST"));
  settings_.processes = {"fastslam", "map-server"};
  EXPECT_THAT(channels_to_play(landmarks, settings_),
              ElementsAre("FEATURES", "GROUND_TRUTH", "ODOMETRY", "TWIST"));
  settings_.processes = {"map-server"};
  EXPECT_EQ(channels_to_play(landmarks, settings_), landmarks);
}

/// A log of landmarks and of a driver that sends velocities.
TEST_F(LogPlayer, LockstepCountsFeaturesWhereThereAreNoImages) {
  const std::string file = (folder_.path() / "landmarks").string();
  LogWriter log(file);
  for (int i = 0; i < 20; ++i) {
    features_t features{};
    twist_t twist{};
    features.utime = sample_start + 100'000 * i;
    twist.utime = features.utime + 50'000;  // logged after the frame that it covers
    log.write(features.utime, "FEATURES", encode_message(features));
    log.write(twist.utime, "TWIST", encode_message(twist));
  }
  log.close();
  settings_.speed = 0;
  settings_.answer_channels = {"FASTSLAM_POSE"};
  settings_.processes = {"odometry", "fastslam"};
  bus_.frames = "FEATURES";
  bus_.readings = "TWIST";
  bus_.mappers = {{"FASTSLAM_POSE"}};
  const PlayCounts counts = play_log(file, settings_, bus_);
  EXPECT_EQ(counts.frames, 20);
  EXPECT_EQ(counts.answered, 20);
  EXPECT_EQ(bus_.mappers[0].dropped, 0);
}

TEST_F(LogPlayer, AtFullSpeedWithoutLockstepSlowMappersDropFrames) {
  settings_.speed = 0;
  bus_.mappers = {{"ICP_POSE"}};
  play_log(sample_log(folder_, 5), settings_, bus_);
  EXPECT_GT(bus_.mappers[0].dropped, 10);
}

TEST_F(LogPlayer, LockstepDropsNothingAtFullSpeed) {
  settings_.speed = 0;
  settings_.answer_channels = {"FASTSLAM_POSE", "ICP_POSE"};
  bus_.mappers = {{"ICP_POSE", milliseconds(40)}, {"FASTSLAM_POSE", milliseconds(25)}};
  const PlayCounts counts = play_log(sample_log(folder_, 5), settings_, bus_);
  EXPECT_EQ(counts.frames, 50);
  EXPECT_EQ(counts.answered, 50);
  for (const auto& mapper : bus_.mappers) {
    EXPECT_EQ(mapper.dropped, 0);
    EXPECT_EQ(mapper.done, 50);
  }
  // Each frame takes the slower mapper's time, and hardly more.
  EXPECT_GE(counts.seconds, 50 * 0.04 - 1e-6);
  EXPECT_LT(counts.seconds, 50 * 0.05);
}

/// Mappers wait for odometry that never comes: so does the player, but not for long.
TEST_F(LogPlayer, LockstepGivesUpSoonWhatTheWheelsDoNotCover) {
  const std::string file = (folder_.path() / "late").string();
  LogWriter log(file);
  write_sample(log, 1);
  const Utime end = sample_start + 1'000'000;
  log.write(end, "CAMERA", camera_message(end, 10));
  log.close();
  settings_.speed = 0;
  settings_.answer_channels = {"ICP_POSE"};
  bus_.mappers = {{"ICP_POSE"}};
  const PlayCounts counts = play_log(file, settings_, bus_);
  EXPECT_EQ(counts.frames, 11);
  EXPECT_EQ(counts.answered, 10);
  EXPECT_EQ(counts.uncovered, 1);
  EXPECT_LT(counts.seconds, 10 * 0.05 + 0.6);
}

TEST_F(LogPlayer, LockstepWithoutAMapperGoesOnAndCounts) {
  settings_.speed = 0;
  settings_.patience = 2;
  settings_.answer_channels = {"ICP_POSE"};
  bus_.mappers = {{"ICP_POSE"}};
  bus_.mappers[0].dead = true;
  const PlayCounts counts = play_log(sample_log(folder_, 1), settings_, bus_);
  EXPECT_EQ(counts.frames, 10);
  EXPECT_EQ(counts.answered, 0);
  EXPECT_EQ(counts.answers.at("ICP_POSE").given_up, 10);
  EXPECT_NEAR(counts.seconds, 20, 0.1);
}

TEST_F(LogPlayer, PlaysASpanAndLoopsUntilStopped) {
  const std::string file = sample_log(folder_, 4);
  settings_.selection.from = LogTime{1};
  settings_.selection.to = LogTime{2};
  settings_.loop = true;
  bus_.stop_after = 3 * (50 + 10 + 1) + 7;
  const PlayCounts counts = play_log(file, settings_, bus_);
  EXPECT_EQ(counts.messages, static_cast<std::int64_t>(bus_.stop_after));
  EXPECT_EQ(count(bus_, "CAMERA_CALIBRATION"), 4U);
  // A pass begins right after the one before.
  EXPECT_NEAR(counts.seconds, 3 * 0.98, 0.1);
}

TEST_F(LogPlayer, JoinsMessagesThatWereLoggedInPieces) {
  const std::string file = (folder_.path() / "pieces").string();
  LogWriter log(file);
  for (int i = 0; i < 5; ++i)
    write_pieces(log, sample_start + 1000 * i, "CAMERA", camera_message(sample_start + 1000 * i, i), i);
  log.close();
  EXPECT_EQ(play_log(file, settings_, bus_).frames, 5);
  EXPECT_EQ(count(bus_, "CAMERA"), 5U);
  EXPECT_EQ(bus_.sent.size(), 5U);
}

TEST_F(LogPlayer, WrongSettingsAreNamed) {
  const std::string file = sample_log(folder_, 1);
  const auto error = [&] {
    try {
      play_log(file, settings_, bus_);
    } catch (const std::exception& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  settings_.speed = -1;
  EXPECT_THAT(error(), HasSubstr("--speed -1"));
  settings_.speed = 1;
  settings_.selection.from = LogTime{100};
  EXPECT_THAT(error(), HasSubstr("no event lies within"));
  settings_.selection = {};
  settings_.selection.channels = {"ENCODERS"};
  settings_.answer_channels = {"ICP_POSE"};
  EXPECT_THAT(error(), HasSubstr("which is not played"));
  EXPECT_TRUE(bus_.sent.empty());
}

}  // namespace
}  // namespace lcmslam
