#include <lcmslam/map_store/file/store_writer.hpp>

#include <gmock/gmock.h>

#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include "tests/support/lossy_disk.hpp"
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class MapStoreWriter : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return folder_ / "run/map.lcmslam"; }
  void SetUp() override { std::filesystem::create_directory(folder_ / "run"); }
  static void put(StoreWriter& writer, std::size_t session, int id) {
    writer.change(session, [&](SessionChanges& changes) { changes.put_landmark(some_landmark(1, id)); });
  }
  std::size_t landmarks_in_file(std::int64_t session = 1) {
    return MapFile(file()).landmarks(session).size();
  }

  TemporaryFolder folder_;
};

TEST_F(MapStoreWriter, WritesWhatComesWithoutBeingAsked) {
  StoreWriter writer(file(), {"1.2", "x: 1"});
  EXPECT_FALSE(std::filesystem::exists(file())) << "nothing to write, no file";
  const std::size_t first = writer.begin_session(session_of("icp"));
  const std::size_t second = writer.begin_session(session_of("fastslam", 8));
  put(writer, second, 1);
  EXPECT_TRUE(testing::wait_for([&] { return writer.state().commits == 1; }));
  EXPECT_EQ(writer.written(second), 1);
  EXPECT_FALSE(writer.written(first));
  EXPECT_EQ(MapFile(file()).sessions().at(0).mapper, "fastslam") << "the other has nothing yet";
  put(writer, first, 1);
  put(writer, second, 2);
  writer.put_calibration({"head", "form", {1}});
  EXPECT_TRUE(writer.flush());
  EXPECT_EQ(MapFile(file()).sessions().size(), 2U);
  EXPECT_EQ(landmarks_in_file(1), 2U);
  EXPECT_EQ(MapFile(file()).runs().size(), 1U);
  EXPECT_EQ(MapFile(file()).calibrations().size(), 1U);
}

TEST_F(MapStoreWriter, WritesTheRestAtItsEnd) {
  {
    StoreWriter writer(file(), {});
    put(writer, writer.begin_session(session_of("fastslam")), 1);
  }
  EXPECT_EQ(landmarks_in_file(), 1U);
  EXPECT_FALSE(std::filesystem::exists(file().string() + "-wal")) << "one file";
}

// Keyframe 0 is in the file, 1 waits, 2 comes when all is shared already; then they go where they come from.
TEST_F(MapStoreWriter, WhatIsSharedStaysWhereItIsSharedWith) {
  StoreWriter writer(file(), {});
  const std::size_t from = writer.begin_session(session_of("icp"));
  const std::size_t to = writer.begin_session(session_of("icp", 8));
  const auto put_all = [&](int id) {
    writer.change(from, [&](SessionChanges& changes) {
      changes.put_keyframe(some_keyframe(id), Matrix6d(4 * Matrix6d::Identity()));
      changes.put_features(id, some_frame_of_features(3, 5 + id));
      changes.put_images(id, some_images(static_cast<std::uint64_t>(id)));
    });
  };
  put_all(0);
  ASSERT_TRUE(writer.flush());
  put_all(1);
  writer.change(to, [&](SessionChanges& changes) {
    for (const int id : {0, 1, 2}) changes.put_keyframe(some_keyframe(id), {});
  });
  writer.share(from, to, {0, 1, 2});
  EXPECT_FALSE(writer.written(from));
  put_all(2);
  writer.change(from, [&](SessionChanges& changes) {
    for (const int id : {0, 1, 2}) changes.drop_keyframe(id);
  });
  ASSERT_TRUE(writer.flush());
  MapFile read(file());
  EXPECT_TRUE(read.keyframes(*writer.written(from)).empty());
  const std::int64_t beside = *writer.written(to);
  ASSERT_EQ(read.keyframes(beside).size(), 3U);
  for (const int id : {0, 1}) {
    ASSERT_TRUE(read.features(beside, id)) << id;
    EXPECT_EQ(read.features(beside, id)->features.size(), static_cast<std::size_t>(5 + id));
    ASSERT_TRUE(read.images(beside, id)) << id;
    EXPECT_TRUE(
        read.images(beside, id)
            ->T_colour_depth_time.isApprox(some_images(static_cast<std::uint64_t>(id)).T_colour_depth_time));
    EXPECT_TRUE(read.keyframes(beside)[static_cast<std::size_t>(id)].covariance) << id;
  }
  EXPECT_FALSE(read.features(beside, 2)) << "it came later";
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

TEST_F(MapStoreWriter, WhatIsSharedMayHaveGoneThere) {
  StoreWriter writer(file(), {});
  const std::size_t from = writer.begin_session(session_of("icp"));
  const std::size_t to = writer.begin_session(session_of("icp", 8));
  writer.change(from, [&](SessionChanges& changes) {
    changes.put_keyframe(some_keyframe(0), {});
    changes.put_features(0, some_frame_of_features(3, 5));
    changes.put_images(0, some_images(1));
  });
  ASSERT_TRUE(writer.flush());
  writer.change(to, [&](SessionChanges& changes) { changes.put_keyframe(some_keyframe(0), {}); });
  writer.share(from, to, {0});
  writer.change(to, [&](SessionChanges& changes) { changes.drop_keyframe(0); });
  EXPECT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_TRUE(MapFile(file()).keyframes(*writer.written(to)).empty());
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

TEST_F(MapStoreWriter, AFolderThatCannotBeMadeIsSaidAndTriedAgain) {
  std::filesystem::remove(folder_ / "run");
  std::ofstream(folder_ / "run") << "a file where the folder should be";
  StoreWriter writer(file(), {});
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  EXPECT_FALSE(writer.flush());
  EXPECT_THAT(writer.state().error, HasSubstr((folder_ / "run").string()));
  put(writer, session, 2);
  EXPECT_FALSE(writer.written(session));
  std::filesystem::remove(folder_ / "run");
  EXPECT_TRUE(testing::wait_for([&] { return writer.state().error.empty(); })) << "by itself";
  EXPECT_EQ(writer.written(session), 1);
  EXPECT_EQ(landmarks_in_file(), 2U);
}

TEST_F(MapStoreWriter, AFullDiskLosesNothingOldAndNothingNew) {
  testing::LossyDisk disk("small");
  StoreWriter writer(file(), {}, disk.vfs());
  const std::size_t session = writer.begin_session(session_of("icp"));
  const auto keyframe = [&](int id) {
    writer.change(session, [&](SessionChanges& c) { c.put_keyframe(some_keyframe(id), std::nullopt); });
  };
  keyframe(1);
  keyframe(2);
  ASSERT_TRUE(writer.flush());
  disk.full = true;
  keyframe(3);
  keyframe(4);
  EXPECT_FALSE(writer.flush());
  EXPECT_THAT(writer.state().error, HasSubstr("disk is full"));
  EXPECT_EQ(MapFile(file()).counts(1).clouds, 2);
  writer.change(session, [](SessionChanges& c) { c.drop_keyframe(4); });
  writer.change(session, [](SessionChanges& c) { c.drop_keyframe(1); });
  keyframe(5);
  EXPECT_FALSE(writer.flush());
  EXPECT_FALSE(writer.written(session));
  disk.full = false;
  EXPECT_TRUE(writer.flush());
  EXPECT_EQ(writer.written(session), 1);
  EXPECT_THAT(writer.state().error, IsEmpty());
  const DenseMap map = MapFile(file()).dense_map(1);
  EXPECT_EQ(map.keyframes().size(), 3U);
  EXPECT_EQ(map.keyframes().count(1) + map.keyframes().count(4), 0U);
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

// Shared while a write is under way that fails; then it goes where it comes from.
TEST_F(MapStoreWriter, WhatAFailedWriteHadIsSharedToo) {
  testing::LossyDisk disk("small");
  StoreWriter writer(file(), {}, disk.vfs());
  const std::size_t from = writer.begin_session(session_of("icp"));
  const std::size_t to = writer.begin_session(session_of("icp", 8));
  put(writer, from, 1);
  ASSERT_TRUE(writer.flush());
  bool shared = false;
  disk.when_full = [&] {
    if (std::exchange(shared, true)) return;
    writer.change(to, [](SessionChanges& changes) { changes.put_keyframe(some_keyframe(0), {}); });
    writer.share(from, to, {0});
    writer.change(from, [](SessionChanges& changes) { changes.drop_keyframe(0); });
  };
  disk.full = true;
  writer.change(from, [](SessionChanges& changes) {
    changes.put_keyframe(some_keyframe(0), {});
    changes.put_features(0, some_frame_of_features(3, 5));
    changes.put_images(0, some_images(1));
  });
  EXPECT_FALSE(writer.flush());
  ASSERT_TRUE(shared);
  disk.full = false;
  ASSERT_TRUE(writer.flush()) << writer.state().error;
  MapFile read(file());
  EXPECT_TRUE(read.keyframes(*writer.written(from)).empty());
  EXPECT_TRUE(read.features(*writer.written(to), 0));
  EXPECT_TRUE(read.images(*writer.written(to), 0));
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

TEST_F(MapStoreWriter, AFileThatIsNoMapStaysAndIsNamed) {
  std::ofstream(file()) << "a letter to my mother, which is long enough to be looked at as a database";
  StoreWriter writer(file(), {});
  put(writer, writer.begin_session(session_of("icp")), 1);
  EXPECT_FALSE(writer.flush());
  EXPECT_THAT(writer.state().error, HasSubstr("not a database"));
}

TEST_F(MapStoreWriter, AFileThatWasTakenAwayBeginsAnewAfterAnError) {
  testing::LossyDisk disk("small");
  StoreWriter writer(file(), {}, disk.vfs());
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  ASSERT_TRUE(writer.flush());
  disk.full = true;
  put(writer, session, 2);
  EXPECT_FALSE(writer.flush());
  std::filesystem::remove_all(folder_ / "run");
  disk.full = false;
  EXPECT_TRUE(writer.flush());
  EXPECT_EQ(landmarks_in_file(), 1U);
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

// Without an error SQLite writes on into a file that has no name any more.
TEST_F(MapStoreWriter, AFileThatIsTakenAwayIsWrittenAgainWhole) {
  StoreWriter writer(file(), {});
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  ASSERT_TRUE(writer.flush());
  std::filesystem::remove(file());  // its log stays
  put(writer, session, 2);
  ASSERT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_EQ(landmarks_in_file(), 2U);
  std::filesystem::remove_all(folder_ / "run");
  put(writer, session, 3);
  ASSERT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_EQ(landmarks_in_file(), 3U);
  EXPECT_EQ(MapFile(file()).runs().size(), 1U);
  EXPECT_EQ(writer.written(session), 1);
  EXPECT_EQ(writer.state().restored, 2);
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

TEST_F(MapStoreWriter, AFileThatIsTakenAwayWaitsForRoom) {
  testing::LossyDisk disk("small");
  StoreWriter writer(file(), {}, disk.vfs());
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  ASSERT_TRUE(writer.flush());
  std::filesystem::remove_all(folder_ / "run");
  disk.full = true;
  put(writer, session, 2);
  EXPECT_FALSE(writer.flush());
  EXPECT_FALSE(std::filesystem::exists(file()));
  disk.full = false;
  ASSERT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_EQ(landmarks_in_file(), 2U);
}

// As `cp another.lcmslam map.lcmslam` does.
TEST_F(MapStoreWriter, AnotherFileThatIsWrittenOverItStaysAsItIs) {
  const std::filesystem::path another = folder_ / "another.lcmslam";
  {
    StoreWriter other(another, {});
    const std::size_t session = other.begin_session(session_of("fastslam", 8));
    for (int id = 0; id < 3; ++id) put(other, session, id);
  }
  const auto copy_over = [&] {
    std::ofstream(file(), std::ios::binary) << std::ifstream(another, std::ios::binary).rdbuf();
  };
  const auto expect_another = [&] {
    EXPECT_EQ(landmarks_in_file(), 3U);
    EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
    EXPECT_FALSE(std::filesystem::exists(file().string() + "-wal"));
  };
  for (const bool more_comes : {true, false}) {
    {
      StoreWriter writer(file(), {});
      const std::size_t session = writer.begin_session(session_of("fastslam"));
      put(writer, session, 1);
      ASSERT_TRUE(writer.flush());
      std::filesystem::last_write_time(file(), std::filesystem::file_time_type::clock::now());
      put(writer, session, 2);
      ASSERT_TRUE(writer.flush()) << "touched alone: " << writer.state().error;
      copy_over();
      if (more_comes) {
        put(writer, session, 3);
        EXPECT_FALSE(writer.flush());
        EXPECT_TRUE(writer.state().overwritten);
        EXPECT_THAT(writer.state().error, HasSubstr("another file was written over it"));
        expect_another();
        put(writer, session, 4);
        EXPECT_FALSE(writer.flush()) << "nor later";
      }
    }
    expect_another();
    std::filesystem::remove(file());
  }
}

TEST_F(MapStoreWriter, WhatAnotherProgramCommitsIsNoOtherFile) {
  StoreWriter writer(file(), {});
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  ASSERT_TRUE(writer.flush());
  Database(file(), Database::Access::write)
      .execute("UPDATE session SET frame = 'other'; CREATE TABLE x(y); PRAGMA wal_checkpoint(TRUNCATE)");
  put(writer, session, 2);
  EXPECT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_EQ(landmarks_in_file(), 2U);
}

TEST_F(MapStoreWriter, WhatAnotherProgramTakesIntoTheFileIsNoOtherFile) {
  StoreWriter writer(file(), {});
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  ASSERT_TRUE(writer.flush());
  Database(file(), Database::Access::write).execute("PRAGMA wal_checkpoint(PASSIVE)");
  put(writer, session, 2);
  EXPECT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_EQ(landmarks_in_file(), 2U);
}

TEST_F(MapStoreWriter, AnotherFileInItsPlaceIsNotWrittenInto) {
  StoreWriter writer(file(), {});
  const std::size_t session = writer.begin_session(session_of("fastslam"));
  put(writer, session, 1);
  ASSERT_TRUE(writer.flush());
  const std::filesystem::path another = folder_ / "another.lcmslam";
  StoreWriter(another, {}).put_calibration({"head", "form", {1}});
  std::filesystem::rename(another, file());
  put(writer, session, 2);
  EXPECT_FALSE(writer.flush());
  EXPECT_THAT(writer.state().error, HasSubstr("another file is in its place"));
  std::filesystem::rename(file(), another);
  ASSERT_TRUE(writer.flush()) << writer.state().error;
  EXPECT_EQ(landmarks_in_file(), 2U);
  EXPECT_EQ(MapFile(another).sessions().size(), 0U);
  EXPECT_THAT(check_map_file(file()).faults, IsEmpty());
}

}  // namespace
}  // namespace lcmslam
