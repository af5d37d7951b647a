// Garbage on every channel of every process: nobody crashes, grows or falls silent, and all of it is
// counted in STATUS.

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <set>

#include "tests/integration/garbage/bad_messages.hpp"
#include "tests/integration/garbage/samples.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"

namespace lcmslam::integration {
namespace {

/// --gtest_random_seed=N gives other garbage.
std::uint64_t seed() {
  return 20100 + static_cast<std::uint64_t>(GTEST_FLAG_GET(random_seed));
}

constexpr double largest_memory = 400e6;  // bytes

struct Target {
  std::string name;  // of the test
  std::string process;
  std::string settings;  // its section
  std::string output;    // channel on which a valid input is answered
};

std::ostream& operator<<(std::ostream& out, const Target& target) {
  return out << target.name;
}

class Garbage : public testing::TestWithParam<Target> {
 protected:
  static void SetUpTestSuite() {
    if (samples_.empty()) samples_ = record_samples(seconds);
  }

  void start() {
    std::ofstream(folder_ / "process.yaml") << GetParam().process << ":\n" << GetParam().settings << "\n";
    program_.emplace(
        std::vector<std::string>{"lcmslam-" + GetParam().process, "--config", folder_ / "process.yaml"},
        folder_.path());
    ASSERT_TRUE(bus_.wait_for_status(
        GetParam().process, [&](const status_t& s) { return s.pid == program_->pid(); }, 30))
        << program_->output();
  }

  /// Channels that the process listens to, as it says itself.
  std::set<std::string> channels() const {
    std::set<std::string> names;
    const auto status = bus_.status(GetParam().process);
    for (const auto& input : status->inputs) names.insert(input.channel);
    return names;
  }

  Bytes sample(const std::string& channel) const {
    Bytes newest;
    for (const Sample& s : samples_)
      if (s.channel == channel) newest = s.bytes;
    return newest;
  }

  void flood(const std::string& channel, const std::vector<Bytes>& messages) {
    // Bytes that any receive buffer holds; where only the newest message is kept, one at a time.
    const std::size_t burst = channel.rfind("CAMERA", 0) == 0 ? 0 : 50'000;
    std::size_t sent = burst;
    for (const Bytes& message : messages) {
      if (sent + message.size() > burst) {
        bus_.wait_until_taken();
        sent = 0;
      }
      bus_.publish(channel, message);
      sent += message.size();
    }
    bus_.wait_until_taken();
  }

  /// Refused or, where newer ones came too fast, dropped unseen.
  std::int64_t turned_away(const std::string& channel, bool with_drops = true) const {
    std::int64_t sum = 0;
    const auto status = bus_.status(GetParam().process);
    for (const auto& input : status->inputs)
      if (input.channel == channel) sum += input.decode_errors + (with_drops ? input.queue_drops : 0);
    return sum;
  }

  void expect_reports_go_on() {
    const std::size_t reports = bus_.status_count(GetParam().process, program_->pid());
    EXPECT_TRUE(wait_until(
        [&] {
          return !program_->running() || bus_.status_count(GetParam().process, program_->pid()) > reports;
        },
        60));
    ASSERT_TRUE(program_->running()) << "signal " << program_->wait(0).signal << "\n" << program_->output();
  }

  /// Plays the valid messages, over and over and each time later, until the process answers one of them.
  bool answers_valid_input() {
    const auto listens = channels();
    const std::size_t answers = bus_.count(GetParam().output);
    return wait_until(
        [&] {
          for (int i = 0; i < 5; ++i) {
            const auto round = static_cast<Utime>(played_ / samples_.size());
            const Sample s =
                later(samples_[played_++ % samples_.size()], round * static_cast<Utime>(1e6 * seconds));
            if (listens.count(s.channel) > 0 && s.channel != "COMMAND") bus_.publish(s.channel, s.bytes);
          }
          return bus_.count(GetParam().output) > answers;
        },
        60);
  }

  static constexpr double seconds = 1.5;
  static std::vector<Sample> samples_;
  std::size_t played_ = 0;  // of the samples, over all rounds
  TemporaryFolder folder_;
  Bus bus_;
  std::optional<Program> program_;
};
std::vector<Sample> Garbage::samples_;

TEST_P(Garbage, IsCountedAndDoesNoHarm) {
  Random random(seed());
  SCOPED_TRACE("seed " + std::to_string(seed()));
  start();
  ASSERT_TRUE(answers_valid_input()) << program_->output();
  const auto listens = channels();
  ASSERT_THAT(listens, testing::Contains("COMMAND"));

  std::map<std::string, std::int64_t> expected;
  for (const std::string& channel : listens) {
    SCOPED_TRACE(channel);
    const Bytes valid = sample(channel);
    ASSERT_FALSE(valid.empty()) << "no sample of " << channel;
    const auto impossible = impossible_messages(valid, random);
    expected[channel] = turned_away(channel) + static_cast<std::int64_t>(impossible.size());
    flood(channel, impossible);
    flood(channel, absurd_messages(valid, random));
    expect_reports_go_on();
    if (channel != "CAMERA") continue;
    // Each at its own time, just before the next round: what comes twice is not looked at.
    auto images = bad_images(valid, random);
    played_ += samples_.size() - played_ % samples_.size();
    const auto rounds = static_cast<double>(played_ / samples_.size());
    for (std::size_t i = 0; i < images.size(); ++i)
      images[i] = later({channel, images[i]},
                        static_cast<Utime>(1e6 * seconds * (rounds - 1)) + 1000 * static_cast<Utime>(i + 1))
                      .bytes;
    // icp leaves out frames that odometry does not explain before it decodes them.
    if (GetParam().process == "surf") expected[channel] += static_cast<std::int64_t>(images.size());
    flood(channel, images);
    expect_reports_go_on();
  }
  for (const auto& [channel, count] : expected) {
    SCOPED_TRACE(channel);
    wait_until([&, c = channel, n = count] { return turned_away(c) >= n; }, 20);
    EXPECT_GE(turned_away(channel), count);
    EXPECT_GT(turned_away(channel, false), 0) << "all were dropped, none was refused";
  }
  EXPECT_TRUE(answers_valid_input()) << program_->output();
  EXPECT_LT(static_cast<double>(bus_.status(GetParam().process)->memory), memory_factor * largest_memory);
  program_->send(SIGINT);
  EXPECT_EQ(program_->wait(60).exit_code, 0) << program_->output();
}

/// launch draws its table from STATUS, whoever sends it.
TEST(GarbageStatus, LaunchGoesOn) {
  const TemporaryFolder folder;
  std::ofstream(folder / "graph.yaml") << "launch: {processes: [odometry]}\n";
  Bus bus;
  Program launch({"lcmslam", "launch", folder / "graph.yaml", "--out", folder / "out"});
  ASSERT_TRUE(bus.wait_for_status(
      "odometry", [](const status_t&) { return true; }, 60))
      << launch.output();
  const auto odometry = bus.status("odometry");
  Bytes valid = encode_message(*odometry);
  Random random(seed());
  for (const auto& messages : {impossible_messages(valid, random), absurd_messages(valid, random)})
    for (const Bytes& message : messages) {
      bus.publish("STATUS", message);
      bus.wait_until_taken();
    }
  EXPECT_TRUE(launch.running()) << launch.output();
  launch.send(SIGINT);
  EXPECT_EQ(launch.wait(60).exit_code, 0) << launch.output();
}

const std::string kitchen = (source_folder() / "config/scenes/kitchen.yaml").string();

INSTANTIATE_TEST_SUITE_P(
    AllProcesses, Garbage,
    testing::Values(Target{"camera", "camera", "  speed: 0.3\n  simulation: {scene: " + kitchen + "}",
                           "CAMERA"},
                    Target{"surf", "surf", "  max_features: 600", "FEATURES"},
                    Target{"wheel_odometry", "odometry", "  source: wheels", "ODOMETRY"},
                    Target{"visual_odometry", "odometry", "  source: visual", "ODOMETRY"},
                    Target{"external_odometry", "odometry", "  source: external", "ODOMETRY"},
                    Target{"fastslam", "fastslam", "  particles: 100", "FASTSLAM_POSE"},
                    Target{"icp", "icp", "  voxel_size: 0.04", "ICP_POSE"},
                    Target{"map_server", "map-server", "  folder: maps", "MAP_REPLY"}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lcmslam::integration
