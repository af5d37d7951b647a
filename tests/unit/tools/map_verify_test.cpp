// What lcmslam map verify and map diff claim of files.

#include <gmock/gmock.h>

#include <fstream>

#include <lcmslam/map_store/file/map_store.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class MapClaims : public ::testing::Test {
 protected:
  testing::CommandRun run(std::vector<std::string> arguments) {
    return testing::run_command({"map", map_command}, std::move(arguments));
  }
  std::filesystem::path file(const std::string& name) const { return folder_ / (name + ".lcmslam"); }

  TemporaryFolder folder_;
};

// A disk that was full or lost power leaves such files.
TEST_F(MapClaims, AFileWithoutAMapIsNotWhole) {
  std::ofstream(file("no_bytes")).close();
  { MapStore store(file("no_session")); }
  for (const char* name : {"no_bytes", "no_session"}) {
    const auto verified = run({"verify", file(name)});
    EXPECT_EQ(verified.exit_code, 1) << name;
    EXPECT_THAT(verified.out, AllOf(HasSubstr("NO MAP"), HasSubstr("nothing has been written into it"),
                                    Not(HasSubstr("whole"))))
        << name;
  }
}

}  // namespace
}  // namespace lcmslam
