#include <gmock/gmock.h>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

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
  testing::CommandRun run(std::vector<std::string> arguments) {
    return testing::run_command({"map", map_command}, std::move(arguments));
  }
  std::filesystem::path file() const { return folder_ / "kitchen.lcmslam"; }

  TemporaryFolder folder_;
};

TEST_F(MapCommand, InfoIsOneScreen) {
  const auto info = run({"info", file()});
  EXPECT_EQ(info.exit_code, 0) << info.errors;
  EXPECT_THAT(info.out, AllOf(HasSubstr("schema 2"), HasSubstr("version 1.2"),
                              ContainsRegex("icp-session2 +4 +200 "), ContainsRegex("fastslam-session1 +0")));
  EXPECT_THAT(run({"info", file(), "--json"}).out,
              AllOf(HasSubstr("\"name\": \"icp-session1\""), HasSubstr("\"landmarks\": 7")));
}

TEST_F(MapCommand, ExportsWhatOthersRead) {
  const auto out = folder_ / "out";
  EXPECT_EQ(run({"export", file(), out, "--resolution", "0"}).exit_code, 0);
  EXPECT_EQ(load_ply(out / "icp-session1_map.ply").size(), 150U);
  EXPECT_EQ(load_pcd(out / "icp-session2_map.pcd").size(), 200U);
  EXPECT_EQ(load_ply(out / "fastslam-session1_map.ply").size(), 7U);
  EXPECT_EQ(read_tum(out / "icp-session1_trajectory.tum").size(), 2U);
  EXPECT_EQ(read_pose_text(out / "icp-session1_trajectory.kitti").trajectory.size(), 2U);
  std::ifstream csv(out / "fastslam-session1_landmarks.csv");
  std::string line;
  for (int i = 0; i < 2; ++i) std::getline(csv, line);
  EXPECT_THAT(line, ContainsRegex("^0,.*,0.003,.*,3,2.5,10,200,30$"));
}

TEST_F(MapCommand, ExportsWhatIsAskedForAndReplacesNothingUnasked) {
  const auto out = folder_ / "out";
  const std::vector<std::string> command = {"export",       file(),      out,  "--sessions",
                                            "icp-session2", "--formats", "ply"};
  EXPECT_EQ(run(command).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(out / "icp-session1_map.ply"));
  EXPECT_FALSE(std::filesystem::exists(out / "icp-session2_map.pcd"));
  EXPECT_EQ(run(command).exit_code, 1) << "the file exists";
  const auto unknown = run({"export", file(), out, "--sessions", "icp-session9"});
  EXPECT_THAT(unknown.errors, AllOf(HasSubstr("icp-session9"), HasSubstr("fastslam-session1")));
}

TEST_F(MapCommand, VerifySaysWhatIsDamagedAndByItsExitCode) {
  EXPECT_EQ(run({"verify", file()}).exit_code, 0);
  EXPECT_THAT(run({"verify", file()}).out, HasSubstr("whole: 3 sessions, 7 keyframes"));
  Database(file(), Database::Access::write).execute("UPDATE landmark SET data = x'00' WHERE id = 4");
  const auto damaged = run({"verify", file()});
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.out, AllOf(HasSubstr("landmark 4"), HasSubstr("DAMAGED")));
}

TEST_F(MapCommand, CompactGivesRoomBack) {
  Database(file(), Database::Access::write).execute("DELETE FROM cloud; DELETE FROM keyframe");
  const auto before = std::filesystem::file_size(file());
  const auto copy = folder_ / "copy.lcmslam";
  EXPECT_EQ(run({"compact", file(), "--out", copy}).exit_code, 0);
  EXPECT_EQ(std::filesystem::file_size(file()), before);
  EXPECT_LT(std::filesystem::file_size(copy), before);
  EXPECT_EQ(run({"verify", copy}).exit_code, 0);
  EXPECT_EQ(run({"compact", file()}).exit_code, 0);
  EXPECT_LT(std::filesystem::file_size(file()), before);
  EXPECT_EQ(run({"diff", file(), copy}).exit_code, 0);
}

TEST_F(MapCommand, AMapThatIsWrittenIsNotCompactedInItsPlace) {
  MapStore writer(file());
  const auto refused = run({"compact", file()});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("database is locked"));
}

TEST_F(MapCommand, DiffSaysWhatMovedAndHowFar) {
  const auto other = folder_ / "other.lcmslam";
  write(other, 0.5);
  Database(other, Database::Access::write).execute("DELETE FROM landmark WHERE id < 2");
  const auto diff = run({"diff", file(), other});
  EXPECT_EQ(diff.exit_code, 1);
  EXPECT_THAT(diff.out, AllOf(HasSubstr("moved by up to 1.5000 m (3)"),
                              HasSubstr("landmarks: 5 in both, 2 only in the first, 0 only in the second")));
  const auto same = run({"diff", file(), file()});
  EXPECT_EQ(same.exit_code, 0);
  EXPECT_THAT(same.out, AllOf(HasSubstr("the maps agree"), Not(HasSubstr("moved"))));
}

TEST_F(MapCommand, FilesThatAreNoMapsAreNamed) {
  for (const std::string command : {"info", "verify", "compact"}) {
    const auto run_of_it = run({command, folder_ / "none.lcmslam"});
    EXPECT_EQ(run_of_it.exit_code, 1);
    EXPECT_THAT(run_of_it.last_line(), AllOf(HasSubstr("none.lcmslam"), HasSubstr("no such file")));
  }
}

}  // namespace
}  // namespace lcmslam
