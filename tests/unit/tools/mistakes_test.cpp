// What a user types wrong: each mistake ends with an exit code that is not 0 and a message that names what
// was wrong or what would be right.

#include <gmock/gmock.h>

#include <regex>

#include <lcmslam/log/log_writer.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/tools/log_samples.hpp"
#include "tests/unit/tools/mistakes.hpp"
#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"
#include "tools/run_commands.hpp"

namespace lcmslam {
namespace {

class Typed : public ::testing::TestWithParam<Mistake> {};

std::string tum_path(double start) {
  std::string text;
  for (int i = 0; i < 20; ++i)
    text += std::to_string(start + 0.1 * i) + " " + std::to_string(0.1 * i) + " 0 0 0 0 0 1\n";
  return text;
}

void write_files(const testing::ScratchFolder& folder) {
  folder.write("notes.txt", "what the robot did today\n");
  folder.write("empty.lcmlog", "");
  folder.write("map.lcmslam", "");
  folder.write("path.txt", tum_path(1000));
  folder.write("later.txt", tum_path(5000));
  folder.write("short.txt", "1000.0 0 0 0 0 0 0 1\n1000.1 0 0 0\n");
  folder.write("degrees.txt", "1000.0 0 0 0 0 0 90 0\n");
  folder.write("point.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
               "property float z\nend_header\n1 2 3\n");
  folder.write("typo.yaml", "lunch:\n  processes: [surf]\n");
  folder.write("process.yaml", "launch:\n  processes: [surff, icp]\n");
  folder.write("tabs.yaml", "icp:\n\tvoxel_size: 0.1\n");
  folder.write("twice.yaml", "icp:\n  voxel_size: 0.1\n  range: 5\n  voxel_size: 0.2\n");
  folder.write("unit.yaml", "icp:\n  voxel_size: 5 cm\n");
  std::filesystem::create_directory(folder.path() / "images");
  folder.write("images/holiday.jpg", "x");
  folder.write("run.db3", "SQLite format 3");
  std::filesystem::create_directory(folder.path() / "rosbag2");
  folder.write("rosbag2/rosbag2_0.db3", "SQLite format 3");
  std::filesystem::create_directory(folder.path() / "tum");
  folder.write("tum/rgb.txt", "1000.0 rgb/1000.0.png\n");
  folder.write("tum/depth.txt", "1000.0 depth/1000.0.png\n");
}

/// Runs in the folder, as a shell would; everything that was printed, in one line.
std::string printed_by(const std::vector<std::string>& words, const std::filesystem::path& folder,
                       int& exit_code) {
  std::vector<std::string> line = {"lcmslam"};
  for (const std::string& word : words)
    line.push_back(word.rfind("@/", 0) == 0 ? source_folder().string() + word.substr(1) : word);
  std::vector<char*> argv;
  for (std::string& word : line) argv.push_back(word.data());
  argv.push_back(nullptr);
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  exit_code = run_commands(commands(), static_cast<int>(line.size()), argv.data());
  std::string text = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  std::filesystem::current_path(before);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

TEST_P(Typed, IsNamed) {
  const testing::ScratchFolder folder;
  write_files(folder);
  std::filesystem::copy(source_folder() / "logs/office_steered.lcmlog", folder.path() / "run.lcmlog");
  int exit_code = 0;
  const std::string text = printed_by(GetParam().words, folder.path(), exit_code);
  EXPECT_NE(exit_code, 0) << text;
  EXPECT_TRUE(std::regex_search(text, std::regex(GetParam().answer)))
      << "it says:  " << text << "\nexpected: " << GetParam().answer;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.lcmlog")) << "a mistake writes nothing";
  EXPECT_EQ(folder.read("notes.txt"), "what the robot did today\n");
  EXPECT_EQ(std::filesystem::file_size(folder.path() / "run.lcmlog"),
            std::filesystem::file_size(source_folder() / "logs/office_steered.lcmlog"));
}

std::string name_of(const ::testing::TestParamInfo<Mistake>& tested) {
  return tested.param.name;
}

INSTANTIATE_TEST_SUITE_P(Mistakes, Typed, ::testing::ValuesIn(mistakes), name_of);

TEST(Mistakes, AreManyAndOverAllCommands) {
  EXPECT_GE(std::size(mistakes), 60U);
  for (const Command& command : commands()) {
    if (std::string(command.name) == "lcm-spy") continue;  // its parts are asked in lcm_spy_test.cpp
    EXPECT_TRUE(std::any_of(std::begin(mistakes), std::end(mistakes), [&](const Mistake& mistake) {
      return !mistake.words.empty() && mistake.words.front() == command.name;
    })) << command.name;
  }
}

}  // namespace
}  // namespace lcmslam
