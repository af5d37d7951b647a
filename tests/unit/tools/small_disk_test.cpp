// A disk that a study fills: the map's file cannot be written, and has everything when there is room again.

#include "tools/study/faults/small_disk.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/store_writer.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"

namespace lcmslam {
namespace {

constexpr int no_mounts = 77;

void fill_a_disk(const std::filesystem::path& folder) {
  const SmallDisk disk(folder, 8);
  const std::filesystem::path file = folder / "map.lcmslam";
  Utime last = 0;
  {
    StoreWriter writer(file, {"1.2", ""});
    const std::size_t session = writer.begin_session(session_of("fastslam"));
    const auto drive = [&] {
      writer.change(session, [&](SessionChanges& changes) {
        changes.append_pose({++last, Eigen::Isometry3d::Identity()});
      });
      return writer.flush();
    };
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(drive());  // its log has room for as much again
    {
      Ballast ballast(folder, file);
      EXPECT_FALSE(drive());
      EXPECT_NE(writer.state().error, "");
      ballast.fill();
      EXPECT_FALSE(drive());
    }
    EXPECT_TRUE(drive()) << writer.state().error;
  }
  MapFile map(file);
  EXPECT_EQ(map.trajectory(map.sessions().at(0).id).size(), static_cast<std::size_t>(last));
}

// In a process of its own, whose mounts are.
TEST(SmallDisk, AMapIsNotWrittenWhileItIsFullAndHasAllAfterwards) {
  const TemporaryFolder folder;
  const pid_t pid = fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    if (!own_mounts()) _exit(no_mounts);
    fill_a_disk(folder / "disk");
    _exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(pid, &status, 0), pid);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == no_mounts) GTEST_SKIP() << "no mounts of its own: that needs root";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace lcmslam
