#pragma once
// What the tests of `lcmslam map` are asked about.

#include <gmock/gmock.h>

#include <lcmslam/map_store/file/map_store.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tools/commands.hpp"

namespace lcmslam::testing {

/// A map of a kitchen: two sessions of icp, one of fastslam.
class MapCommand : public ::testing::Test {
 protected:
  static void write(const std::filesystem::path& file, double shift = 0) {
    MapStore store(file);
    Transaction transaction = store.begin();
    const std::int64_t run = store.add_run({"1.2", ""});
    for (int session = 0; session < 2; ++session) {
      SessionChanges dense;
      for (int id = 0; id < 3 + session; ++id) {
        DenseKeyframe keyframe = some_keyframe(id, 50);
        keyframe.T_world_camera.translation().x() += shift * id;
        dense.put_keyframe(keyframe, std::nullopt);
      }
      dense.append_pose({100, Eigen::Isometry3d::Identity()});
      dense.append_pose({200, Eigen::Isometry3d::Identity()});
      store.write(store.add_session(run, session_of("icp")), dense);
    }
    SessionChanges sparse;
    for (int id = 0; id < 7; ++id) sparse.put_landmark(some_landmark(static_cast<std::uint64_t>(id), id));
    store.write(store.add_session(run, session_of("fastslam")), sparse);
    transaction.commit();
  }
  void SetUp() override { write(file()); }
  /// A map whose writer was killed: its last changes stand in SQLite's log beside it.
  void leave_with_log(const std::filesystem::path& killed) {
    const auto alive = folder_ / "alive.lcmslam";
    MapStore store(alive);
    write(alive, 0.25);
    for (const char* ending : {"", "-wal"})
      std::filesystem::copy_file(alive.string() + ending, killed.string() + ending);
    ASSERT_GT(std::filesystem::file_size(killed.string() + "-wal"), 1000U);
  }
  CommandRun run(std::vector<std::string> arguments) {
    return run_command({"map", map_command}, std::move(arguments));
  }
  std::filesystem::path file() const { return folder_ / "kitchen.lcmslam"; }

  TemporaryFolder folder_;
};

}  // namespace lcmslam::testing
