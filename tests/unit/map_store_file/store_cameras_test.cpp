// Images are read by the calibration that they were taken by, whatever is told of their sensor later.

#include <gmock/gmock.h>

#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/compact_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include "tests/unit/map_store_file/sample_store.hpp"

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class StoredCameras : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return folder_ / "kitchen.lcmslam"; }

  static StoredCalibration told(std::uint8_t what, const std::string& sensor = "head") {
    return {sensor, "form", {what}};
  }
  /// Keyframe 1, taken by that calibration; none: it is not said by which.
  static SessionChanges taken_by(const std::optional<StoredCalibration>& calibration) {
    SessionChanges changes;
    changes.put_keyframe(some_keyframe(1), std::nullopt);
    StoredImages images = some_images(1);
    if (calibration) images.calibration = std::make_shared<StoredCalibration>(*calibration);
    changes.put_images(1, images);
    return changes;
  }
  static std::int64_t add_session(MapStore& store, const SessionChanges& changes) {
    const std::int64_t session = store.add_session(store.add_run({"1.2", ""}), session_of("icp"));
    store.write(session, changes);
    return session;
  }
  /// A session that is told this calibration and takes its images by it.
  void map_by(const StoredCalibration& calibration) {
    MapStore store(file());
    Transaction transaction = store.begin();
    store.put_calibration(calibration);
    add_session(store, taken_by(calibration));
    transaction.commit();
  }
  void execute(const std::string& sql) { Database(file(), Database::Access::write).execute(sql); }
  /// As the third version of the schema had it.
  void make_old() {
    execute("ALTER TABLE images DROP COLUMN camera; DROP TABLE camera; PRAGMA user_version = 3");
  }
  /// First bytes of the calibrations of the sessions' keyframes; -1: not known.
  static std::vector<int> read(const std::filesystem::path& file) {
    std::vector<int> cameras;
    MapFile map(file);
    for (const StoredSession& session : map.sessions()) {
      const auto images = map.images(session.id, 1);
      EXPECT_EQ(images.value().frame.depth.bytes, some_images(1).frame.depth.bytes);
      cameras.push_back(images->calibration ? images->calibration->bytes.at(0) : -1);
    }
    return cameras;
  }
  std::vector<std::string> faults() { return check_map_file(file()).faults; }

  TemporaryFolder folder_;
};

TEST_F(StoredCameras, EachImageKeepsItsOwn) {
  map_by(told(1));
  map_by(told(2));
  map_by(told(1));
  EXPECT_THAT(read(file()), ElementsAre(1, 2, 1));
  EXPECT_EQ(MapFile(file()).cameras().size(), 2U) << "what says the same is there once";
  ASSERT_EQ(MapFile(file()).calibrations().size(), 1U);
  EXPECT_EQ(MapFile(file()).calibrations()[0].bytes, told(1).bytes) << "told last";
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(StoredCameras, ASessionMayChangeIt) {
  map_by(told(1));
  SessionChanges more;
  more.put_keyframe(some_keyframe(2), std::nullopt);
  StoredImages images = some_images(2);
  images.calibration = std::make_shared<StoredCalibration>(told(2));
  more.put_images(2, images);
  MapStore(file()).write(1, more);
  MapFile map(file());
  EXPECT_EQ(map.images(1, 1)->calibration->bytes, told(1).bytes);
  EXPECT_EQ(map.images(1, 2)->calibration->bytes, told(2).bytes);
  EXPECT_EQ(map.images(1, 2)->calibration->sensor, "head");
  EXPECT_EQ(map.images(1, 2)->calibration->form, "form");
}

TEST_F(StoredCameras, CompactedFilesAndThoseOfAKilledWriterHaveThem) {
  map_by(told(1));
  map_by(told(2));
  compact_map_file(file());
  EXPECT_THAT(read(file()), ElementsAre(1, 2));
  const auto copy = folder_ / "copy.lcmslam", killed = folder_ / "killed.lcmslam";
  copy_compacted(file(), FilePlace(copy));
  EXPECT_THAT(read(copy), ElementsAre(1, 2));

  MapStore writer(file());
  Transaction transaction = writer.begin();
  add_session(writer, taken_by(told(3)));
  transaction.commit();
  for (const char* ending : {"", "-wal"})
    std::filesystem::copy_file(file().string() + ending, killed.string() + ending);
  EXPECT_THAT(read(killed), ElementsAre(1, 2, 3));
}

// Nothing in them says by which calibration images were taken: it was the one that had been told last.
TEST_F(StoredCameras, OldFilesAreReadAsBeforeAndGoneOnWith) {
  map_by(told(1));
  map_by(told(2));
  make_old();
  EXPECT_THAT(read(file()), ElementsAre(2, 2));
  EXPECT_EQ(MapFile(file()).schema(), 3);
  EXPECT_EQ(MapFile(file()).cameras().size(), 1U);
  EXPECT_THAT(faults(), IsEmpty());
  map_by(told(3));
  EXPECT_EQ(MapFile(file()).schema(), newest_schema);
  EXPECT_THAT(read(file()), ElementsAre(2, 2, 3)) << "what is told later changes nothing";
  compact_map_file(file());
  EXPECT_THAT(read(file()), ElementsAre(2, 2, 3));
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(StoredCameras, OldFilesSayMoreInTheNamesOfSensors) {
  map_by(told(1, "head;rolling_shutter=0.03"));
  map_by(told(2, "headlight"));
  make_old();
  EXPECT_THAT(read(file()), ElementsAre(1, 1));
  map_by(told(3));
  EXPECT_THAT(read(file()), ElementsAre(1, 1, 3));
}

TEST_F(StoredCameras, WhereNothingIsSaidItIsWhatWasToldLast) {
  MapStore store(file());
  add_session(store, taken_by(std::nullopt));
  store.put_calibration(told(1, "tof"));
  store.put_calibration(told(2));
  add_session(store, taken_by(std::nullopt));
  store.put_calibration(told(3));
  EXPECT_THAT(read(file()), ElementsAre(-1, 2)) << "the first knew none";
  EXPECT_THAT(faults(), IsEmpty());
}

TEST_F(StoredCameras, ThoseThatAreDamagedOrMissingAreNamed) {
  map_by(told(1));
  execute("UPDATE camera SET data = zeroblob(length(data))");
  EXPECT_THAT(faults(), ::testing::Contains(HasSubstr("the blob is of kind 0")));
  execute("DELETE FROM camera");
  EXPECT_THAT(faults(), ElementsAre(HasSubstr("there is no camera 1")));
}

}  // namespace
}  // namespace lcmslam
