#include "tools/lcm-spy/spy_launch.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/unit/tools/scratch.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class LcmSpy : public ::testing::Test {
 protected:
  void put(const std::string& name, bool program = false) {
    const fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "x";
    if (program) fs::permissions(file, fs::perms::owner_all);
  }
  SpyParts find(const std::string& display = ":0") const {
    const std::string search = (folder_ / "nowhere").string() + ":" + (folder_ / "usr/bin").string();
    return find_spy_parts(search, {folder_ / "jars"}, folder_ / "own", display);
  }
  std::string obstacle(const std::string& display = ":0") const { return spy_obstacle(find(display)); }

  const testing::ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
};

TEST_F(LcmSpy, EachMissingPartIsNamedWithItsCure) {
  EXPECT_THAT(obstacle(), HasSubstr("no Java"));
  put("usr/bin/java");
  EXPECT_THAT(obstacle(), HasSubstr("no Java")) << "a file that is no program";
  fs::remove(folder_ / "usr/bin/java");

  put("jvm/bin/java", true);
  fs::create_symlink(folder_ / "jvm/bin/java", folder_ / "usr/bin/java");
  EXPECT_THAT(obstacle(), HasSubstr("apt-get install default-jre"));
  put("jvm/lib/libawt_xawt.so");
  EXPECT_THAT(obstacle(), HasSubstr("apt-get install liblcm-java"));
  put("jars/lcm.jar");
  EXPECT_THAT(obstacle(), HasSubstr("apt-get install libjchart2d-java"));
  put("jars/jchart2d.jar");
  EXPECT_THAT(obstacle(), HasSubstr("lcmslam_types.jar was not built"));
  put("own/lcmslam_types.jar");
  EXPECT_THAT(obstacle(), HasSubstr("lcmslam_spy.jar was not built"));
  put("own/lcmslam_spy.jar");
  EXPECT_THAT(obstacle(""), HasSubstr("DISPLAY is not set"));
  EXPECT_THAT(obstacle(":98765"), HasSubstr("no X server answers at DISPLAY=:98765"));
  EXPECT_EQ(obstacle("desk.example:0.0"), "") << "displays of other machines are not asked";
  EXPECT_EQ(missing_part(find("")), "") << "to print the command no display is needed";
  fs::remove(folder_ / "jvm/lib/libawt_xawt.so");
  EXPECT_EQ(missing_part(find("")), "") << "nor a Java that draws";
  fs::remove(folder_ / "jars/lcm.jar");
  EXPECT_THAT(missing_part(find("")), HasSubstr("apt-get install liblcm-java"));
}

TEST_F(LcmSpy, CommandHasEveryJarTheBusAndWhatElseWasGiven) {
  SpyParts parts;
  parts.java = "/j/java";
  parts.lcm_jar = "/a.jar";
  parts.chart_jar = "/b.jar";
  parts.types_jar = "/c.jar";
  parts.plugin_jar = "/d.jar";
  EXPECT_THAT(spy_arguments(parts, "udpm://x?ttl=0&y", {"-h"}),
              ElementsAre("/j/java", "-Djava.net.preferIPv4Stack=true", "-Xmx256m", "-cp",
                          "/a.jar:/b.jar:/c.jar:/d.jar", "lcm.spy.Spy", "--lcm-url=udpm://x?ttl=0&y", "-h"));
}

// Which parts this machine has is its own business; that it has no display is not asked.
TEST(LcmSpyCommand, PrintsWithoutADisplay) {
  unsetenv("DISPLAY");
  char name[] = "lcm-spy", print[] = "--print";
  char* argv[] = {name, print, nullptr};
  ::testing::internal::CaptureStdout();
  std::string error;
  try {
    lcm_spy_command(2, argv);
  } catch (const std::runtime_error& missing) {
    error = missing.what();
  }
  const std::string printed = ::testing::internal::GetCapturedStdout();
  if (error.empty()) {
    EXPECT_THAT(printed, HasSubstr("'lcm.spy.Spy'"));
  } else {
    EXPECT_THAT(error, HasSubstr("apt-get install"));
  }
  EXPECT_THAT(error, ::testing::Not(HasSubstr("display")));
}

}  // namespace
}  // namespace lcmslam
