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

// Keyframes at the same places may show other points.
TEST_F(MapClaims, DiffSaysWhatItDidNotCompare) {
  for (const char* name : {"first", "second"}) {
    MapStore store(file(name));
    Transaction transaction = store.begin();
    SessionChanges changes;
    changes.put_keyframe(some_keyframe(0, name == std::string("first") ? 50 : 20), std::nullopt);
    store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp")), changes);
    transaction.commit();
  }
  const auto diff = run({"diff", file("first"), file("second")});
  EXPECT_EQ(diff.exit_code, 0);
  EXPECT_THAT(diff.out,
              AllOf(HasSubstr("the maps agree in their keyframes' poses and their landmarks' means"),
                    HasSubstr("points, features, images, edges, covariances and paths were not")));
}

}  // namespace
}  // namespace lcmslam
