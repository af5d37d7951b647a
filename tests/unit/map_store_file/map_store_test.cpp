#include <lcmslam/map_store/file/map_store.hpp>

#include <gmock/gmock.h>
#include <fstream>

#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/store_codecs.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

class MapStoreFile : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return folder_ / "kitchen.lcmslam"; }

  /// All of it as one process would, of one session; gives that.
  std::int64_t write(const SessionChanges& changes, const std::string& mapper = "icp") {
    MapStore store(file());
    Transaction transaction = store.begin();
    const std::int64_t session =
        store.add_session(store.add_run({"1.2", "resolution: 0.02"}), session_of(mapper));
    store.write(session, changes);
    transaction.commit();
    return session;
  }
  void write_more(std::int64_t session, const SessionChanges& changes) {
    MapStore store(file());
    Transaction transaction = store.begin();
    store.write(session, changes);
    transaction.commit();
  }
  void execute(const std::string& sql) { Database(file(), Database::Access::write).execute(sql); }
  std::vector<std::string> faults() { return check_map_file(file()).faults; }

  TemporaryFolder folder_;
};

TEST_F(MapStoreFile, TheMapsFrameIsThatOfTheFirstSessionInWhichOthersCanBeFound) {
  SessionChanges bare, with_features, with_landmarks;
  for (SessionChanges* changes : {&bare, &with_features})
    changes->put_keyframe(some_keyframe(3), Matrix6d::Identity());
  with_features.put_features(3, some_frame_of_features(1, 5));
  with_landmarks.put_landmark(some_landmark(1, 20));
  const std::int64_t first = write(bare);
  EXPECT_EQ(MapFile(file()).frame_session("icp"), first) << "there is no other";
  EXPECT_EQ(MapFile(file()).frame_session("fastslam"), std::nullopt);
  const std::int64_t of_landmarks = write(with_landmarks, "fastslam"), second = write(with_features);
  write(with_features);
  EXPECT_EQ(MapFile(file()).frame_session("icp"), second);
  EXPECT_EQ(MapFile(file()).frame_session("fastslam"), of_landmarks);
}

TEST_F(MapStoreFile, GivesBackWhatWasPutIntoIt) {
  SessionChanges changes;
  changes.put_keyframe(some_keyframe(3), Matrix6d::Identity());
  changes.put_features(3, some_frame_of_features(1, 5));
  changes.put_images(3, some_images(1));
  changes.move_keyframe(4, 4000, some_keyframe(4).T_world_camera);  // a node that has no cloud
  changes.set_edges({3, 4}, {edge_between(3, 4), edge_between(3, 4)});
  changes.put_landmark(some_landmark(1, 20));
  changes.append_pose({77, some_keyframe(5).T_world_camera});
  const std::int64_t session = write(changes);

  MapFile read(file());
  EXPECT_EQ(read.schema(), newest_schema);
  EXPECT_EQ(read.runs().at(0).configuration, "resolution: 0.02");
  ASSERT_EQ(read.sessions().size(), 1U);
  EXPECT_EQ(read.sessions()[0].id, session);
  EXPECT_EQ(read.sessions()[0].mapper, "icp");
  EXPECT_EQ(read.sessions()[0].frame, "map");
  const DenseMap map = read.dense_map(session);
  ASSERT_EQ(map.keyframes().size(), 1U);
  EXPECT_TRUE(map.keyframes().at(3).T_world_camera.isApprox(some_keyframe(3).T_world_camera, 1e-12));
  EXPECT_EQ(map.keyframes().at(3).utime, 3000);
  EXPECT_EQ(map.point_count(), 40U);
  EXPECT_EQ(read.keyframes(session).size(), 2U);
  EXPECT_TRUE(read.keyframes(session)[0].covariance->isIdentity());
  EXPECT_FALSE(read.keyframes(session)[1].covariance);
  EXPECT_EQ(read.features(session, 3)->features.size(), 5U);
  EXPECT_EQ(read.images(session, 3)->frame.depth.bytes, some_images(1).frame.depth.bytes);
  EXPECT_FALSE(read.images(session, 4));
  EXPECT_EQ(read.edges(session).size(), 2U);
  EXPECT_EQ(read.edges(session)[1].to, 4);
  EXPECT_EQ(read.landmarks(session).at(0).id, 20);
  EXPECT_EQ(read.trajectory(session).at(0).utime, 77);
  EXPECT_EQ(read.counts(session).points, 40);
  EXPECT_THAT(faults(), IsEmpty());
  EXPECT_EQ(check_map_file(file()).loose_edges, 0);
}

TEST_F(MapStoreFile, ACorrectionMovesWhatIsKept) {
  SessionChanges changes;
  changes.put_keyframe(some_keyframe(1), Matrix6d::Identity());
  const std::int64_t session = write(changes);
  const Eigen::Isometry3d corrected(Eigen::Translation3d(1, 2, 3));
  SessionChanges correction;
  correction.move_keyframe(1, 1000, corrected);
  write_more(session, correction);
  MapFile read(file());
  EXPECT_TRUE(read.dense_map(session).keyframes().at(1).T_world_camera.isApprox(corrected));
  EXPECT_TRUE(read.keyframes(session)[0].covariance) << "the correction says nothing of it";
}

TEST_F(MapStoreFile, KeyframesThatGoTakeAllThatHangsOnThem) {
  SessionChanges changes;
  for (const int id : {1, 2, 3}) {
    changes.put_keyframe(some_keyframe(id), std::nullopt);
    changes.put_features(id, some_frame_of_features(1, 2));
    changes.put_images(id, some_images(2));
  }
  for (const auto& [from, to] : {std::pair(1, 2), std::pair(2, 3), std::pair(1, 3)})
    changes.set_edges({from, to}, {edge_between(from, to)});
  const std::int64_t session = write(changes);
  SessionChanges less;
  less.drop_keyframe(2);
  write_more(session, less);
  SessionChanges late;
  late.put_features(2, some_frame_of_features(1, 2));
  late.put_images(2, some_images(2));
  write_more(session, late);
  MapFile read(file());
  const SessionCounts counts = read.counts(session);
  EXPECT_EQ(counts.clouds, 2);
  EXPECT_EQ(counts.features, 2);
  EXPECT_EQ(counts.images, 2);
  ASSERT_EQ(counts.edges, 1);
  EXPECT_EQ(read.edges(session)[0].to, 3);
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(MapStoreFile, LandmarksAndEdgesAreReplacedDroppedAndCleared) {
  SessionChanges changes;
  for (const int id : {1, 2, 3}) changes.put_landmark(some_landmark(1, id));
  changes.set_edges({1, 2}, {edge_between(1, 2)});
  changes.set_edges({2, 3}, {edge_between(2, 3)});
  const std::int64_t session = write(changes, "fastslam");
  SessionChanges newer;
  Landmark moved = some_landmark(1, 2);
  moved.mean.x() = 99;
  newer.put_landmark(moved);
  newer.drop_landmark(3);
  newer.set_edges({1, 2}, {});
  write_more(session, newer);
  {
    MapFile read(file());
    ASSERT_EQ(read.landmarks(session).size(), 2U);
    EXPECT_EQ(read.landmarks(session)[1].mean.x(), 99);
    EXPECT_EQ(read.edges(session).size(), 1U);
  }
  SessionChanges anew;
  anew.clear_landmarks();
  anew.clear_edges();
  anew.put_landmark(some_landmark(1, 8));
  write_more(session, anew);
  MapFile read(file());
  ASSERT_EQ(read.landmarks(session).size(), 1U);
  EXPECT_EQ(read.landmarks(session)[0].id, 8);
  EXPECT_THAT(read.edges(session), IsEmpty());
}

TEST_F(MapStoreFile, ASecondRunGoesOnBesideTheFirst) {
  SessionChanges changes;
  changes.put_landmark(some_landmark(1, 1));
  const std::int64_t first = write(changes, "fastslam"), second = write(changes, "fastslam");
  EXPECT_EQ(MapFile(file()).sessions().size(), 2U);
  EXPECT_EQ(MapFile(file()).runs().size(), 2U);
  EXPECT_EQ(MapFile(file()).landmarks(first).size(), 1U);
  EXPECT_EQ(MapFile(file()).landmarks(second).size(), 1U);
}

TEST_F(MapStoreFile, SaysWhereASessionLies) {
  SessionChanges changes;
  changes.put_landmark(some_landmark(1, 1));
  StoredSession session = session_of("fastslam");
  session.id = write(changes, "fastslam");
  EXPECT_FALSE(MapFile(file()).sessions()[0].T_map_session) << "nobody knows";
  session.state = SessionState::joined;
  session.T_map_session = Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0));
  session.evidence = "40 of 60 descriptors agree";
  {
    MapStore store(file());
    store.place_session(session);
    session.id = 99;
    EXPECT_THAT([&] { store.place_session(session); }, ThrowsMessage<StoreError>(HasSubstr("session 99")));
  }
  const StoredSession read = MapFile(file()).sessions()[0];
  EXPECT_EQ(read.state, SessionState::joined);
  EXPECT_TRUE(read.T_map_session->isApprox(*session.T_map_session));
  EXPECT_EQ(read.evidence, "40 of 60 descriptors agree");
}

TEST_F(MapStoreFile, CalibrationsAreKeptBySensor) {
  {
    MapStore store(file());
    store.put_calibration({"head", "form", {1, 2}});
    store.put_calibration({"head", "form", {3}});
    store.put_calibration({"tof", "form", {4}});
  }
  const auto calibrations = MapFile(file()).calibrations();
  ASSERT_EQ(calibrations.size(), 2U);
  EXPECT_EQ(calibrations[0].bytes, std::vector<std::uint8_t>{3});
}

// As the first version of the schema wrote it, before sessions had a place.
TEST_F(MapStoreFile, FilesOfTheFirstSchemaAreReadAndGoneOnWith) {
  const auto hex = [](const Blob& blob) {
    std::ostringstream text;
    for (const int byte : blob) text << std::hex << (byte >> 4) << (byte & 15);
    return "x'" + text.str() + "'";
  };
  Database(file(), Database::Access::create)
      .execute(
          "CREATE TABLE run(id INTEGER PRIMARY KEY, version TEXT NOT NULL, configuration TEXT NOT NULL);"
          "CREATE TABLE session(id INTEGER PRIMARY KEY, run INTEGER NOT NULL, mapper TEXT NOT NULL,"
          " sender INTEGER NOT NULL, frame TEXT NOT NULL);"
          "CREATE TABLE calibration(sensor TEXT PRIMARY KEY, form TEXT NOT NULL, data BLOB NOT NULL);"
          "CREATE TABLE keyframe(session INTEGER, id INTEGER, utime INTEGER, pose BLOB, covariance BLOB,"
          " PRIMARY KEY(session, id)) WITHOUT ROWID;"
          "CREATE TABLE cloud(session INTEGER, keyframe INTEGER, points INTEGER, data BLOB,"
          " PRIMARY KEY(session, keyframe));"
          "CREATE TABLE features(session INTEGER, keyframe INTEGER, data BLOB,"
          " PRIMARY KEY(session, keyframe));"
          "CREATE TABLE edge(session INTEGER, from_keyframe INTEGER, to_keyframe INTEGER, number INTEGER,"
          " data BLOB, PRIMARY KEY(session, from_keyframe, to_keyframe, number)) WITHOUT ROWID;"
          "CREATE TABLE landmark(session INTEGER, id INTEGER, data BLOB, PRIMARY KEY(session, id))"
          " WITHOUT ROWID;"
          "CREATE TABLE trajectory(session INTEGER, number INTEGER, data BLOB,"
          " PRIMARY KEY(session, number)) WITHOUT ROWID;"
          "INSERT INTO run VALUES(1, '0.9', 'old');"
          "INSERT INTO session VALUES(5, 1, 'fastslam', 42, 'map');"
          "INSERT INTO landmark VALUES(5, 20, " +
          hex(encode_landmark(some_landmark(1, 20))) +
          ");"
          "PRAGMA application_id = 1280527437; PRAGMA user_version = 1");
  EXPECT_EQ(MapFile(file()).schema(), 1);
  EXPECT_EQ(MapFile(file()).landmarks(5).at(0).id, 20);
  EXPECT_EQ(MapFile(file()).sessions().at(0).sender, 42);
  SessionChanges changes;
  changes.put_landmark(some_landmark(1, 1));
  EXPECT_EQ(write(changes, "fastslam"), 6);
  EXPECT_EQ(MapFile(file()).schema(), newest_schema);
  EXPECT_EQ(MapFile(file()).landmarks(5).at(0).mean, some_landmark(1, 20).mean);
  EXPECT_FALSE(MapFile(file()).sessions().at(0).T_map_session);
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(MapStoreFile, FilesOfOthersAreRefusedAndStayAsTheyAre) {
  const auto refuses = [&](const std::string& why) {
    EXPECT_THAT([&] { MapStore store(file()); },
                ThrowsMessage<StoreError>(AllOf(HasSubstr(file().string()), HasSubstr(why))));
    EXPECT_THAT([&] { MapFile read(file()); }, ThrowsMessage<StoreError>(HasSubstr(why)));
  };
  EXPECT_THAT([&] { MapFile read(file()); }, ThrowsMessage<StoreError>(HasSubstr("no such file")));
  std::ofstream(file()) << std::string(5000, 'x');
  refuses("not a database");
  EXPECT_EQ(std::filesystem::file_size(file()), 5000U);
  std::filesystem::remove(file());
  Database(file(), Database::Access::create).execute("CREATE TABLE birds(name TEXT)");
  refuses("no map of lcmslam");
  std::filesystem::remove(file());
  { MapStore store(file()); }
  execute("PRAGMA user_version = 99");
  refuses("schema version 99");
  std::filesystem::rename(file(), folder_ / "other");
  std::filesystem::create_symlink(folder_ / "other", file());
  refuses("symbolic link");
}

TEST_F(MapStoreFile, AnEmptyFileIsAnEmptyMap) {
  std::ofstream(file()).close();
  EXPECT_THAT(MapFile(file()).sessions(), IsEmpty());
  EXPECT_THAT(faults(), IsEmpty());
  { MapStore store(file()); }
  EXPECT_EQ(MapFile(file()).schema(), newest_schema);
}

TEST_F(MapStoreFile, AnyNameWillDo) {
  const auto odd = folder_ / "a run #2?\n'x'%41.lcmslam";
  { MapStore store(odd); }
  EXPECT_EQ(MapFile(odd).schema(), newest_schema);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) files += entry.exists();
  EXPECT_EQ(files, 1U) << "nothing stays beside it";
}

TEST_F(MapStoreFile, DamageIsFoundAndNamed) {
  SessionChanges changes;
  changes.put_keyframe(some_keyframe(3), std::nullopt);
  changes.put_landmark(some_landmark(1, 20));
  const std::int64_t session = write(changes);
  execute("UPDATE landmark SET data = zeroblob(length(data))");
  EXPECT_THAT(faults(), ::testing::ElementsAre(HasSubstr("landmark 20 of session 1: the blob is of kind 0")));
  EXPECT_THAT([&] { MapFile(file()).landmarks(session); },
              ThrowsMessage<StoreError>(HasSubstr(file().string())));
  execute("DELETE FROM landmark; UPDATE cloud SET points = 5");
  EXPECT_THAT(faults(), ::testing::ElementsAre(HasSubstr("counts 5 points")));
  execute("DELETE FROM keyframe");
  EXPECT_THAT(faults(), ::testing::ElementsAre(HasSubstr("a row of cloud refers to a keyframe")));
}

TEST_F(MapStoreFile, ReadersSeeOneMomentWhileOthersWrite) {
  SessionChanges changes;
  changes.put_landmark(some_landmark(1, 1));
  const std::int64_t session = write(changes);
  MapFile read(file());
  SessionChanges more;
  more.put_landmark(some_landmark(1, 2));
  write_more(session, more);
  EXPECT_EQ(read.landmarks(session).size(), 1U);
  EXPECT_EQ(MapFile(file()).landmarks(session).size(), 2U);
}

}  // namespace
}  // namespace lcmslam
