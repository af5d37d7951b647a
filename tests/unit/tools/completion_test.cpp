#include "tools/completion/completion.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <sstream>

#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;

/// What bash would offer for the last of these words.
std::vector<std::string> replies(const std::vector<std::string>& words) {
  const testing::ScratchFolder scratch;
  scratch.write("run.lcmlog", "");
  std::string text = completion_script("bash") + "COMP_WORDS=(";
  for (const std::string& word : words) text += " '" + word + "'";
  text += ")\nCOMP_CWORD=" + std::to_string(words.size() - 1) + "\ncd '" + scratch.path().string() +
          "'\n_lcmslam\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
  const std::string command = "bash --norc " + scratch.write("run.sh", text).string() + " 2>&1";
  std::FILE* pipe = popen(command.c_str(), "r");
  std::string output;
  std::array<char, 4096> buffer;
  while (const std::size_t size = std::fread(buffer.data(), 1, buffer.size(), pipe))
    output.append(buffer.data(), size);
  EXPECT_EQ(pclose(pipe), 0) << output;
  std::vector<std::string> lines;
  std::istringstream stream(output);
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

TEST(BashCompletion, OffersTheCommands) {
  EXPECT_THAT(replies({"lcmslam", "la"}), ElementsAre("launch"));
  EXPECT_THAT(replies({"lcmslam", "b"}), UnorderedElementsAre("batch", "bench", "bridge", "build"));
  const auto all = replies({"lcmslam", ""});
  for (const Command& command : commands()) EXPECT_THAT(all, Contains(command.name));
}

TEST(BashCompletion, OffersTheOptionsOfACommand) {
  EXPECT_THAT(replies({"lcmslam", "batch", "--"}),
              AllOf(Contains("--out"), Contains("--from"), Contains("--set"), Contains("--help"),
                    Not(Contains("--private-bus"))));
  EXPECT_THAT(replies({"lcmslam", "batch", "--th"}), ElementsAre("--threads"));
  EXPECT_THAT(replies({"lcmslam", "log", "play", "--lo"}), UnorderedElementsAre("--loop", "--lockstep"));
}

TEST(BashCompletion, OffersSubcommands) {
  EXPECT_THAT(replies({"lcmslam", "log", "re"}), ElementsAre("repair"));
  EXPECT_THAT(replies({"lcmslam", "calibrate", "camera", "--pic"}), ElementsAre("--pictures"));
}

TEST(BashCompletion, OffersKeysAfterSet) {
  EXPECT_THAT(replies({"lcmslam", "batch", "--set", "icp.coarse.max_d"}),
              ElementsAre("icp.coarse.max_distance="));
  EXPECT_THAT(replies({"lcmslam", "launch", "robot.yaml", "--set", "surf."}),
              AllOf(Contains("surf.octaves="), Each(StartsWith("surf."))));
}

TEST(BashCompletion, OffersTheChoicesOfAKey) {
  EXPECT_THAT(replies({"lcmslam", "batch", "--set", "icp.variant", "=", "f"}), ElementsAre("frustum"));
  EXPECT_THAT(replies({"lcmslam", "batch", "--set", "icp.graph.enabled", "="}),
              UnorderedElementsAre("true", "false"));
  EXPECT_THAT(replies({"lcmslam", "batch", "--set", "icp.voxel_size", "="}), IsEmpty());
}

TEST(BashCompletion, OffersWhatConfigExplainsAndLists) {
  EXPECT_THAT(replies({"lcmslam", "config", "--explain", "map-server.r"}),
              ElementsAre("map-server.resolution"));
  EXPECT_THAT(replies({"lcmslam", "config", "--list", "f"}), ElementsAre("fastslam"));
}

TEST(BashCompletion, OffersWordsAndFiles) {
  EXPECT_THAT(replies({"lcmslam", "completion", "z"}), ElementsAre("zsh"));
  EXPECT_THAT(replies({"lcmslam", "evaluate", "--alignment", "se"}), UnorderedElementsAre("se2", "se3"));
  EXPECT_THAT(replies({"lcmslam", "log", "info", "run.l"}), ElementsAre("run.lcmlog"));
  EXPECT_THAT(replies({"lcmslam", "batch", "run"}), UnorderedElementsAre("run.lcmlog", "run.sh"));
}

// There need be no zsh here: what both shells share is tested above.
TEST(ZshCompletion, HasTheSameTables) {
  const std::string bash = completion_script("bash"), zsh = completion_script("zsh");
  const auto tables = [](const std::string& script) {
    const std::size_t begin = script.find("_lcmslam_commands");
    return script.substr(begin, script.find("\n_lcmslam() {") - begin);
  };
  EXPECT_EQ(tables(bash), tables(zsh));
  EXPECT_THAT(zsh, HasSubstr("compdef _lcmslam lcmslam"));
}

}  // namespace
}  // namespace lcmslam
