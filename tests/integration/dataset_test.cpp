// Recordings: `lcmslam import` and `lcmslam demo --data`; and what happens when input is wrong.

#include <gmock/gmock.h>

#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"
#include "tests/support/recordings.hpp"

namespace lcmslam::integration {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Decodes every event, domain checks included, and counts by channel.
std::map<std::string, int> decode_all(const std::filesystem::path& file) {
  std::map<std::string, int> counts;
  lcm::LogFile log(file, "r");
  EXPECT_TRUE(log.good()) << file;
  while (const lcm::LogEvent* event = log.good() ? log.readNextEvent() : nullptr) {
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    const auto size = static_cast<std::size_t>(event->datalen);
    if (event->channel == "CAMERA") {
      const EncodedFrame frame = from_message(decode_message<images_t>(data, size));
      EXPECT_EQ(frame.seq, counts["CAMERA"]);
    } else if (event->channel == "CAMERA_CALIBRATION") {
      EXPECT_NO_THROW(from_message(decode_message<camera_calibration_t>(data, size)).check());
    } else if (event->channel == "GROUND_TRUTH") {
      const auto truth = decode_message<ground_truth_t>(data, size);
      EXPECT_TRUE(from_message(truth.T_frame_child, "T_frame_child").matrix().allFinite());
    } else {
      ADD_FAILURE() << "unexpected channel " << event->channel;
    }
    ++counts[event->channel];
  }
  return counts;
}

struct Recording {
  const char* folder;
  int frames;
  int least_truths;
};

class Import : public testing::TestWithParam<Recording> {};

TEST_P(Import, WritesEveryFrameWithItsTruth) {
  const auto folder = ::lcmslam::recording_path(GetParam().folder);
  LCMSLAM_SKIP_WITHOUT(GetParam().folder);
  const TemporaryFolder out;
  const Result result = run({"lcmslam", "import", folder, out / "run.lcmlog"}, 120);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  auto counts = decode_all(out / "run.lcmlog");
  EXPECT_EQ(counts["CAMERA"], GetParam().frames);
  EXPECT_GE(counts["GROUND_TRUTH"], GetParam().least_truths);
  EXPECT_GE(counts["CAMERA_CALIBRATION"], 1);
  EXPECT_FALSE(std::filesystem::exists(out / "run.lcmlog.part"));
}

INSTANTIATE_TEST_SUITE_P(Recordings, Import,
                         testing::Values(Recording{"rgbd_slambook2", 5, 5},
                                         Recording{"livingroom1", 211, 211}),
                         [](const auto& instance) { return instance.param.folder; });

void expect_maps(const std::filesystem::path& folder, std::size_t least_landmarks) {
  EXPECT_GT(load_ply(folder / "fastslam_map.ply").size(), least_landmarks);
  EXPECT_GT(load_ply(folder / "icp_map.ply").size(), 1'000U);
  std::ifstream file(folder / "summary.json");
  const auto summary = nlohmann::json::parse(file);
  for (const std::string mapper : {"fastslam", "icp"})
    EXPECT_GT(summary.at("paths").at(mapper).at("poses"), 0) << mapper;
}

TEST(DemoOfRecording, FiveFramesGiveMaps) {
  const auto folder = ::lcmslam::recording_path("rgbd_slambook2");
  LCMSLAM_SKIP_WITHOUT("rgbd_slambook2");
  const TemporaryFolder out;
  const Result result = run({"lcmslam", "demo", "--data", folder, "--headless", "--out", out.path()}, 180);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  expect_maps(out.path(), 5);  // views far apart share few features
}

TEST(DemoOfRecording, ThreeSecondsOfAHandHeldCameraGiveMaps) {
  const auto folder = ::lcmslam::recording_path("tum_fr1_rpy");
  LCMSLAM_SKIP_WITHOUT("tum_fr1_rpy");
  const TemporaryFolder out;
  const Result result =
      run({"lcmslam", "demo", "--data", folder, "--headless", "--seconds", "3", "--out", out.path()}, 180);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  expect_maps(out.path(), 100);
}

TEST(WrongInput, AFolderThatIsNoDataSetIsNamed) {
  const TemporaryFolder folder;
  std::ofstream(folder / "holiday.txt") << "no camera in sight\n";
  const Result import = run({"lcmslam", "import", folder.path(), folder / "run.lcmlog"}, 30);
  EXPECT_THAT(import.exit_code, testing::AnyOf(1, 2));
  EXPECT_THAT(import.output, HasSubstr(folder.path()));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.lcmlog"));

  const Result demo =
      run({"lcmslam", "demo", "--data", folder.path(), "--headless", "--out", folder / "out"}, 90);
  EXPECT_EQ(demo.exit_code, 2) << demo.output;
  EXPECT_THAT(demo.output, HasSubstr(folder.path()));
}

TEST(WrongInput, AMissingFolderIsNamed) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"lcmslam", "demo", "--data", "/nowhere/at-all"},
        std::vector<std::string>{"lcmslam", "import", "/nowhere/at-all", "/tmp/never-written.lcmlog"}}) {
    const Result result = run(command, 30);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.output, HasSubstr("/nowhere/at-all"));
  }
}

/// A configuration with `max_featurs` in its third line.
std::string misspelt_configuration(const TemporaryFolder& folder) {
  std::ofstream(folder / "misspelt.yaml")
      << "include: " << (source_folder() / "config/demo.yaml").string() << "\n"
      << "surf:\n  max_featurs: 300\n";
  return folder / "misspelt.yaml";
}

TEST(WrongInput, AWrongKeyIsToldWithFileLineAndTheNearestKey) {
  const TemporaryFolder folder;
  const std::string config = misspelt_configuration(folder);
  const auto tells = AllOf(HasSubstr(config + ":3"), HasSubstr("max_featurs"), HasSubstr("max_features"));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"lcmslam-surf", "--config", config},
        std::vector<std::string>{"lcmslam", "launch", config, "--out", folder / "launch"},
        std::vector<std::string>{"lcmslam", "demo", "--headless", "--config", config, "--out",
                                 folder / "demo"}}) {
    SCOPED_TRACE(command[0] + " " + command[1]);
    const Result result = run(command, 90);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_THAT(result.output, tells);
  }
}

TEST(WrongInput, AWrongProcessNameIsTold) {
  const TemporaryFolder folder;
  std::ofstream(folder / "graph.yaml") << "launch:\n  processes: [surf, odometri]\n";
  const Result result = run({"lcmslam", "launch", folder / "graph.yaml", "--out", folder / "out"}, 30);
  EXPECT_THAT(result.exit_code, testing::AnyOf(1, 2)) << result.output;
  EXPECT_THAT(result.output, AllOf(HasSubstr("graph.yaml:2"), HasSubstr("odometri")));
}

TEST(WrongInput, ADamagedSceneEndsTheDemo) {
  const TemporaryFolder folder;
  std::ofstream(folder / "scene.yaml") << "name: broken\nlights: 7\n";
  const Result result = run({"lcmslam", "demo", "--headless", "--out", folder / "out", "--set",
                             "camera.simulation.scene=" + (folder / "scene.yaml").string()},
                            90);
  EXPECT_EQ(result.exit_code, 2) << result.output;
  EXPECT_THAT(result.output, HasSubstr("scene.yaml"));
}

}  // namespace
}  // namespace lcmslam::integration
