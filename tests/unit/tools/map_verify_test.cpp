// Whether a map's file is whole, as small as it can be, and the same as another.

#include "tests/unit/tools/map_command_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::MapCommand;
using ::testing::Not;

TEST_F(MapCommand, VerifySaysWhatIsDamagedAndByItsExitCode) {
  EXPECT_EQ(run({"verify", file()}).exit_code, 0);
  EXPECT_THAT(run({"verify", file()}).out,
              HasSubstr("whole: 3 sessions, 7 nodes (7 keyframes with a cloud)"));
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

// SQLite would write the old file's log over the new one.
TEST_F(MapCommand, WhatTakesTheNameOfAKilledWritersMapIsItselfOnly) {
  const auto copy = folder_ / "copy.lcmslam";
  leave_with_log(copy);
  EXPECT_EQ(run({"compact", file(), "--out", copy, "--force"}).exit_code, 0);
  const auto diff = run({"diff", file(), copy});
  EXPECT_EQ(diff.exit_code, 0) << diff.out << diff.errors;
}

TEST_F(MapCommand, AMapThatIsOpenIsNotReplaced) {
  const auto copy = folder_ / "copy.lcmslam";
  write(copy, 0.25);
  {
    MapStore writer(copy);
    const auto refused = run({"compact", file(), "--out", copy, "--force"});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.errors, AllOf(HasSubstr("copy.lcmslam"), HasSubstr("database is locked")));
  }
  EXPECT_EQ(run({"diff", file(), copy}).exit_code, 1) << "it stays as it was";
  EXPECT_EQ(run({"compact", file(), "--out", file(), "--force"}).exit_code, 0) << "nobody else has it open";
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
  for (const auto& map : {file(), other})
    Database(map, Database::Access::write)
        .execute("DELETE FROM landmark; DELETE FROM cloud; DELETE FROM keyframe");
  const auto nothing = run({"diff", file(), other});
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.out, HasSubstr("nothing was compared"));
}

TEST_F(MapCommand, DiffComparesTheSessionsOfOneProcessAlone) {
  const auto other = folder_ / "other.lcmslam";
  write(other);
  Database(other, Database::Access::write).execute("UPDATE session SET sender = 8");
  const auto strangers = run({"diff", file(), other});
  EXPECT_EQ(strangers.exit_code, 1);
  EXPECT_THAT(strangers.out, AllOf(HasSubstr("icp-session1: only in the first"),
                                   HasSubstr("icp-session1: only in the second"), HasSubstr("map merge"),
                                   Not(HasSubstr("moved"))));
  EXPECT_THAT(strangers.out, Not(::testing::ContainsRegex("[1-9][0-9]* in both")));

  write(other.string() + "2");  // behind another run's session, as after a merge
  Database(other.string() + "2", Database::Access::write)
      .execute(
          "UPDATE session SET sender = 8 WHERE id = 1; DELETE FROM cloud WHERE session = 2 AND keyframe = 3; "
          "DELETE FROM keyframe WHERE session = 2 AND id = 3");
  const auto behind = run({"diff", file(), other.string() + "2"});
  EXPECT_THAT(behind.out,
              AllOf(HasSubstr("icp-session1 (icp-session2 of the second): the same places"),
                    HasSubstr("fastslam-session1: the same places"), Not(HasSubstr("map merge"))));
}

// As a process leaves them that was killed when it had just begun.
TEST_F(MapCommand, FilesWithoutTablesStayEmptyMaps) {
  const auto empty = folder_ / "empty.lcmslam", copy = folder_ / "copy.lcmslam";
  Database(empty, Database::Access::create).execute("PRAGMA journal_mode = WAL; BEGIN IMMEDIATE; COMMIT");
  for (int i = 0; i < 2; ++i) EXPECT_EQ(run({"compact", empty}).exit_code, 0);
  const auto copied = run({"compact", empty, "--out", copy});
  EXPECT_EQ(copied.exit_code, 0) << copied.errors;
  for (const auto& map : {empty, copy}) {
    const auto info = run({"info", map});
    EXPECT_EQ(info.exit_code, 0) << info.errors;
    for (const auto& diff : {run({"diff", map, file()}), run({"diff", file(), map})}) {
      EXPECT_EQ(diff.exit_code, 1);
      EXPECT_THAT(diff.out, AllOf(HasSubstr("fastslam-session1: only in the "), HasSubstr("the maps differ")))
          << diff.errors;
    }
    write(map);
    EXPECT_EQ(run({"diff", map, file()}).exit_code, 0) << "a map goes on in it";
  }
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
