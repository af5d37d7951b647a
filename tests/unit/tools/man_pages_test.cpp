#include "tools/completion/man_pages.hpp"

#include <gmock/gmock.h>

#include <sstream>

#include "tests/unit/tools/scratch.hpp"
#include "tools/command_description.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(ManPages, AreThereForEveryCommandAndListedByTheFirst) {
  const auto pages = man_pages();
  for (const Command& command : commands()) {
    const std::string name = std::string("lcmslam-") + command.name;
    ASSERT_EQ(pages.count(name + ".1"), 1U) << name;
    EXPECT_STRNE(command.help, "") << command.name;
    EXPECT_THAT(pages.at(name + ".1"), HasSubstr(".SH NAME\nlcmslam\\-")) << name;
  }
  EXPECT_THAT(pages.at("lcmslam.1"), HasSubstr("lcmslam\\-lcm\\-spy\\fR(1)"));
  for (const char* variable : {"LCM_DEFAULT_URL", "LCMSLAM_BUS_ALLOW", "LCMSLAM_BUS_KEY",
                               "LCMSLAM_BUS_MEMORY", "LCMSLAM_ROBOT", "LCMSLAM_SHARE", "NO_COLOR"})
    EXPECT_THAT(pages.at("lcmslam.1"), HasSubstr(std::string("\\fB") + variable + "\\fR"));
  EXPECT_THAT(pages.at("lcmslam-log.1"), HasSubstr("lcmslam\\-log\\-cut\\fR(1)"));
  EXPECT_THAT(pages.at("lcmslam-log-cut.1"), HasSubstr("lcmslam log cut"));
}

TEST(ManPages, SayEveryOptionOfItsCommand) {
  const std::string page = man_pages().at("lcmslam-batch.1");
  for (const OptionDescription& option : describe_command(batch_command))
    for (const std::string& name : option.names) {
      std::string escaped;
      for (const char c : name) escaped += c == '-' ? std::string("\\-") : std::string(1, c);
      EXPECT_THAT(page, HasSubstr("\\fB" + escaped + "\\fR"));
    }
  EXPECT_THAT(page, HasSubstr("[OPTIONS] \\fIconfig\\fR [\\fIlog\\fR...]"));
  EXPECT_THAT(
      page,
      HasSubstr(".TP\n\\fIlog\\fR\n\\&.lcmlog with CAMERA"));  // a leading dot would be a command of roff
  EXPECT_THAT(man_pages().at("lcmslam-evaluate.1"), HasSubstr("[\\fIestimate\\fR...]"));
  EXPECT_THAT(man_pages().at("lcmslam-evaluate.1"),
              HasSubstr("\\fB\\-\\-alignment\\fR first\\-pose|none|se2|se3|sim3"));
}

TEST(ManPages, HaveNoLineThatRoffWouldTakeForAnUnknownRequest) {
  const std::set<std::string> known = {".TH", ".SH", ".B", ".BR", ".TP"};
  for (const auto& [name, text] : man_pages()) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      const bool request = !line.empty() && (line[0] == '.' || line[0] == '\'');
      EXPECT_TRUE(!request || known.count(line.substr(0, line.find(' '))) == 1) << name << ": " << line;
    }
    EXPECT_THAT(text, Not(HasSubstr("\n\n"))) << name;
  }
}

TEST(ManPages, AreWrittenIntoAFolder) {
  const testing::ScratchFolder scratch;
  write_man_pages(scratch.path() / "man");
  EXPECT_EQ(scratch.read("man/lcmslam-spy.1"), man_pages().at("lcmslam-spy.1"));
}

}  // namespace
}  // namespace lcmslam
