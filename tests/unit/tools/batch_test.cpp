// The whole graph straight from a log: bit for bit the same, whatever the threads, and whatever else is in
// the log.

#include <gmock/gmock.h>

#include <lcmslam/images_t.hpp>
#include <lcmslam/log/log_reader.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/parts.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/batch/batch_run.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::ScratchFolder;

const std::filesystem::path kitchen = source_folder() / "logs/kitchen.lcmlog";

constexpr int frames = 15;  // of the first 1.5 s at 10 Hz; the camera's stamps are not the wheels'

BatchOptions options(const std::filesystem::path& log, const std::filesystem::path& folder) {
  BatchOptions o;
  o.config = load_config(source_folder() / "config/replay.yaml", {});
  o.log = log;
  o.folder = folder;
  o.to = 1.5;
  return o;
}

std::map<std::string, std::string> files(const std::filesystem::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ostringstream text;
    text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    all[entry.path().filename()] = text.str();
  }
  return all;
}

/// Names of the files that differ.
std::vector<std::string> differing(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::vector<std::string> names;
  auto of_b = files(b);
  for (const auto& [name, content] : files(a)) {
    if (of_b.count(name) == 0 || of_b[name] != content) names.push_back(name);
    of_b.erase(name);
  }
  for (const auto& [name, content] : of_b) names.push_back(name);
  return names;
}

/// Copies the log, each event changed to any number of events.
void rewrite(const std::filesystem::path& from, const std::filesystem::path& to,
             const std::function<void(const LogEvent&, LogWriter&)>& change) {
  LogReader reader(from.string());
  LogWriter writer(to.string());
  while (const auto event = reader.next()) change(*event, writer);
  writer.close();
}

class Batch : public ::testing::Test {
 protected:
  /// What all are compared with is run once.
  static void SetUpTestSuite() {
    reference_scratch_ = std::make_unique<ScratchFolder>();
    reference_ = run_batch(options(kitchen, reference()));
  }
  static void TearDownTestSuite() { reference_scratch_.reset(); }
  static std::filesystem::path reference() { return reference_scratch_->path() / "reference"; }
  std::filesystem::path folder(const std::string& name) const { return scratch_.path() / name; }

  ScratchFolder scratch_;
  inline static std::unique_ptr<ScratchFolder> reference_scratch_;
  inline static BatchResult reference_;
};

TEST_F(Batch, MapsEveryFrame) {
  EXPECT_EQ(reference_.frames, frames);
  EXPECT_EQ(reference_.damages, 0U);
  std::map<std::string, int> count;
  LogReader log(reference_.output.string());
  Utime last = 0;
  while (const auto event = log.next()) {
    ++count[event->channel];
    EXPECT_GE(event->timestamp, last);
    last = event->timestamp;
  }
  EXPECT_EQ(count["FEATURES"], frames);
  EXPECT_EQ(count["FASTSLAM_POSE"], frames);
  EXPECT_EQ(count["ICP_POSE"], frames);
  EXPECT_GT(count["ODOMETRY"], 70);
  EXPECT_GT(count["FASTSLAM_LANDMARKS"], 0);
  EXPECT_GT(count["ICP_KEYFRAME"], 0);
  EXPECT_EQ(count.count("STATUS"), 0U);
  EXPECT_TRUE(std::filesystem::exists(reference() / "fastslam_map.ply"));
  EXPECT_TRUE(std::filesystem::exists(reference() / "icp_map.ply"));
}

TEST_F(Batch, IsTheSameForAnyNumberOfThreads) {
  for (const int threads : {1, 2, 4}) {
    BatchOptions o = options(kitchen, folder(std::to_string(threads)));
    o.threads = threads;
    run_batch(o);
    EXPECT_THAT(differing(reference(), o.folder), ::testing::IsEmpty()) << threads << " threads";
  }
}

TEST_F(Batch, TellsHowManyFramesAreDone) {
  BatchOptions o = options(kitchen, folder("progress"));
  std::vector<std::int64_t> done;
  o.progress = [&](std::int64_t frame) { done.push_back(frame); };
  const BatchPlan plan = plan_batch(o);
  EXPECT_EQ(plan.frames, frames);
  run_batch(o, plan);
  ASSERT_FALSE(done.empty());
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(done.back(), plan.frames);
}

TEST_F(Batch, TheSourceThatAutoFindsGivesTheSameAsItsName) {
  BatchOptions o = options(kitchen, folder("named"));
  o.config = load_config(source_folder() / "config/replay.yaml", {"odometry.source=wheels"});
  run_batch(o);
  EXPECT_THAT(differing(reference(), folder("named")), ::testing::IsEmpty());
}

TEST_F(Batch, NeverReadsGroundTruth) {
  const auto log = scratch_.path() / "without.lcmlog";
  int truths = 0;
  rewrite(kitchen, log, [&](const LogEvent& event, LogWriter& writer) {
    if (event.channel == "GROUND_TRUTH")
      ++truths;
    else
      writer.write(event.timestamp, event.channel, event.data);
  });
  ASSERT_GT(truths, 50);
  run_batch(options(log, folder("without")));
  EXPECT_THAT(differing(reference(), folder("without")), ::testing::IsEmpty());
}

TEST_F(Batch, LeavesOutWhatTheGraphMakesItselfAndPutsPiecesTogether) {
  const auto log = scratch_.path() / "parts.lcmlog";
  std::int64_t messages = 0;
  rewrite(kitchen, log, [&](const LogEvent& event, LogWriter& writer) {
    if (event.channel != "CAMERA") return writer.write(event.timestamp, event.channel, event.data);
    for (const part_t& part : split_message("CAMERA", event.data, event.timestamp, messages, 40'000))
      writer.write(event.timestamp, "CAMERA_PART", encode_message(part));
    writer.write(event.timestamp, "FEATURES", {1, 2, 3});
    writer.write(event.timestamp, "COMMAND", {1, 2, 3});
    writer.write(event.timestamp, "SOMEBODY ELSE'S", {1, 2, 3});
    ++messages;
  });
  const BatchResult result = run_batch(options(log, folder("parts")));
  EXPECT_EQ(result.frames, frames);
  EXPECT_EQ(result.incomplete, 0);
  EXPECT_THAT(differing(reference(), folder("parts")), ::testing::IsEmpty());
}

TEST_F(Batch, BeginsInTheMiddleWithTheCalibrationFromBefore) {
  BatchOptions o = options(kitchen, folder("middle"));
  o.from = 0.5;
  o.to = 0.95;
  const BatchResult result = run_batch(o);
  EXPECT_EQ(result.frames, 5);
  for (const auto& process : result.processes) EXPECT_EQ(process.decode_errors, 0) << process.process;
  LogReader log(result.output.string());
  int features = 0;
  while (const auto event = log.next()) features += event->channel == "FEATURES" ? 1 : 0;
  EXPECT_EQ(features, 5);
}

TEST_F(Batch, TakesTheSpanFromEverySessionOfALog) {
  std::ofstream twice(folder("twice.lcmlog"), std::ios::binary);
  for (int i = 0; i < 2; ++i) twice << std::ifstream(kitchen, std::ios::binary).rdbuf();
  twice.close();
  BatchOptions o = options(folder("twice.lcmlog"), folder("sessions"));
  o.from = 0.5;
  o.to = 3.85;
  const BatchResult result = run_batch(o);
  EXPECT_EQ(result.frames, 68);
  LogReader log(result.output.string());
  std::vector<Utime> times;
  while (const auto event = log.next())
    if (event->channel == "FEATURES") times.push_back(event->timestamp);
  // That time began anew is believed after half a second.
  ASSERT_GE(times.size(), 34U + 25U);
  ASSERT_LT(times.size(), 68U);
  for (std::size_t i = 1; i <= 25; ++i) EXPECT_EQ(times[times.size() - i], times[34 - i]);
}

/// The kitchen with every CAMERA message changed.
template <class Change>
BatchResult run_changed(const ScratchFolder& scratch, const Change& change) {
  const auto log = scratch.path() / "changed.lcmlog";
  rewrite(kitchen, log, [&](const LogEvent& event, LogWriter& writer) {
    if (event.channel != "CAMERA") return writer.write(event.timestamp, event.channel, event.data);
    auto message = decode_message<images_t>(event.data.data(), event.data.size());
    change(message);
    writer.write(event.timestamp, event.channel, encode_message(message));
  });
  BatchOptions o = options(log, scratch.path() / "out");
  o.to = 0.5;
  return run_batch(o);
}

void leave_out(images_t& message, std::size_t image) {
  message.images.erase(message.images.begin() + static_cast<std::ptrdiff_t>(image));
  message.image_types.erase(message.image_types.begin() + static_cast<std::ptrdiff_t>(image));
  --message.n_images;
}

TEST(BatchProblems, FramesThatAllAreRefusedAreNamedWithTheCause) {
  for (const auto& [image, missing] : {std::pair(0, "no colour image"), std::pair(1, "no depth image")}) {
    const ScratchFolder scratch;
    const auto problems = problems_of(
        run_changed(scratch, [&](images_t& m) { leave_out(m, static_cast<std::size_t>(image)); }));
    ASSERT_FALSE(problems.empty()) << missing;
    EXPECT_THAT(problems.front(),
                AllOf(HasSubstr("refused"), HasSubstr("CAMERA messages"), HasSubstr(missing)));
  }
}

TEST(BatchProblems, AFewDamagedFramesAreNone) {
  const ScratchFolder scratch;
  int n = 0;
  const BatchResult result = run_changed(scratch, [&](images_t& m) {
    if (n++ % 3 == 1) leave_out(m, 1);
  });
  EXPECT_GT(result.processes.front().decode_errors, 0);
  EXPECT_THAT(problems_of(result), ::testing::IsEmpty());
}

TEST(BatchProblems, CalibrationsThatAllAreRefusedMapNothing) {
  const ScratchFolder scratch;
  const auto log = scratch.path() / "uncalibrated.lcmlog";
  rewrite(kitchen, log, [&](const LogEvent& event, LogWriter& writer) {
    const bool calibrates = event.channel == "CAMERA_CALIBRATION";
    writer.write(event.timestamp, event.channel,
                 calibrates ? std::vector<std::uint8_t>{1, 2, 3} : event.data);
  });
  const auto problems = problems_of(run_batch(options(log, scratch.path() / "out")));
  ASSERT_FALSE(problems.empty());
  EXPECT_THAT(problems.front(), HasSubstr("CAMERA_CALIBRATION messages"));
  EXPECT_THAT(problems, ::testing::Contains("icp mapped nothing: it waits for CAMERA_CALIBRATION"));
}

TEST(BatchProblems, MostFramesWithoutOdometryAreOne) {
  const ScratchFolder scratch;
  const auto log = scratch.path() / "short_of_wheels.lcmlog";
  int readings = 0;
  rewrite(kitchen, log, [&](const LogEvent& event, LogWriter& writer) {
    if (event.channel != "ENCODERS" || ++readings < 10)
      writer.write(event.timestamp, event.channel, event.data);
  });
  const auto problems = problems_of(run_batch(options(log, scratch.path() / "out")));
  EXPECT_THAT(problems, ::testing::Contains(HasSubstr("icp had no odometry for")));
}

TEST(BatchProblems, MapsThatCannotBeSavedAreNamedAndTheLogIsKept) {
  const ScratchFolder scratch;
  BatchOptions o = options(kitchen, scratch.path() / "out");
  o.to = 0.5;
  std::filesystem::create_directories(o.folder / "icp_map.pcd");  // in the way
  const BatchResult result = run_batch(o);
  EXPECT_THAT(problems_of(result),
              ::testing::ElementsAre(AllOf(HasSubstr("maps are not saved"), HasSubstr("icp_map.pcd"),
                                           HasSubstr("is a folder"))));
  EXPECT_TRUE(std::filesystem::exists(result.output));
}

TEST(BatchErrors, NameWhatIsWrong) {
  ScratchFolder scratch;
  BatchOptions o = options(kitchen, scratch.path() / "out");
  o.config.set("icp.voxel_sice", "1");
  try {
    run_batch(o);
    FAIL() << "a wrong key was accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("voxel_size"));
  }
  EXPECT_FALSE(std::filesystem::exists(o.folder / "batch.lcmlog"));
  o = options(scratch.write("no.lcmlog", "this is no log"), scratch.path() / "out");
  EXPECT_THROW(run_batch(o), std::runtime_error);
}

}  // namespace
}  // namespace lcmslam
