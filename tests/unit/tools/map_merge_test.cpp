#include <gmock/gmock.h>

#include <fstream>

#include <lcmslam/map_store/file/map_file.hpp>
#include "tests/support/full_disk.hpp"
#include "tests/support/landmark_room.hpp"
#include "tests/support/seen_kitchen.hpp"
#include "tests/unit/tools/map_command_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;
using testing::MapCommand;
using ::testing::Not;

/// Each drive is another process's.
std::int64_t sender_of(const std::filesystem::path& file) {
  return static_cast<std::int64_t>(std::hash<std::string>()(file.filename().string()));
}

/// Of one dense session: what was seen in six frames of the kitchen, or its mirror image.
void write_room(const std::filesystem::path& file, int from, const Eigen::Isometry3d& T_map_world,
                bool mirrored = false) {
  SessionChanges changes;
  for (int id = 0; id < 6; ++id) {
    const testing::SeenView& known = testing::seen_view(from + 5 * id);
    const testing::SeenView view = mirrored ? known.mirrored() : known;
    changes.put_keyframe({id, view.features.utime, T_map_world * view.T_world_camera, view.cloud, 0},
                         std::nullopt);
    changes.put_features(id, view.features);
  }
  MapStore store(file);
  Transaction transaction = store.begin();
  store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp", sender_of(file))), changes);
  transaction.commit();
}

Eigen::Isometry3d elsewhere() {
  return Eigen::Translation3d(2, -1, 0) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
         Eigen::Isometry3d::Identity();
}

void write_landmarks(const std::filesystem::path& file, const std::vector<Landmark>& landmarks) {
  SessionChanges changes;
  for (const Landmark& landmark : landmarks) changes.put_landmark(landmark);
  MapStore store(file);
  Transaction transaction = store.begin();
  store.write(store.add_session(store.add_run({"1.2", ""}), session_of("fastslam", sender_of(file))),
              changes);
  transaction.commit();
}

/// Two maps of one place, and one of another.
class MapMerge : public MapCommand {
 protected:
  void write_landmark_maps() {
    const testing_scene::LandmarkRoom room(1);
    write_landmarks(monday_, room.mapped(Eigen::Isometry3d::Identity(), 1));
    write_landmarks(friday_, room.mapped(elsewhere(), 2));
    write_landmarks(strange_, testing_scene::LandmarkRoom(2).mapped(elsewhere(), 2));
  }

  const std::string monday_ = folder_ / "monday.lcmslam", friday_ = folder_ / "friday.lcmslam",
                    strange_ = folder_ / "strange.lcmslam", both_ = folder_ / "both.lcmslam";
};

TEST_F(MapMerge, FindsWhereTheSecondMapLies) {
  write_room(monday_, 60, Eigen::Isometry3d::Identity());
  write_room(friday_, 62, elsewhere());
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  MapFile map(both_);
  const auto sessions = map.sessions();
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_EQ(map.dense_map(2).keyframes().size(), 6U);
  ASSERT_TRUE(sessions[1].T_map_session);
  EXPECT_LT(distance_between(*sessions[1].T_map_session, elsewhere().inverse()), 0.02);
  EXPECT_LT(angle_between(*sessions[1].T_map_session, elsewhere().inverse()), 0.01);
  EXPECT_EQ(run({"verify", both_}).exit_code, 0);
  EXPECT_NE(run({"merge", monday_, friday_, "--into", both_}).exit_code, 0) << "it is there already";
}

TEST_F(MapMerge, KeepsWhatSpokeForASessionThatHadBeenJoined) {
  write_room(monday_, 60, Eigen::Isometry3d::Identity());
  write_room(friday_, 62, elsewhere());
  write_room(friday_, 64, elsewhere());
  {
    MapStore store(friday_);
    Transaction transaction = store.begin();
    StoredSession joined = session_of("icp");
    joined.id = 2;
    joined.state = SessionState::joined;
    joined.T_map_session = Eigen::Isometry3d::Identity();
    joined.evidence = "6 of 6 keyframes in the kitchen";
    store.place_session(joined);
    transaction.commit();
  }
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  const auto sessions = MapFile(both_).sessions();
  ASSERT_EQ(sessions.size(), 3U);
  EXPECT_THAT(sessions[1].evidence, Not(HasSubstr("in the kitchen")));
  EXPECT_EQ(sessions[2].evidence,
            "6 of 6 keyframes in the kitchen; the map in which they were found: " + sessions[1].evidence);
}

TEST_F(MapMerge, KnowsMapsOfLandmarksAlone) {
  write_landmark_maps();
  EXPECT_NE(run({"merge", monday_, strange_, "--into", both_}).exit_code, 0);
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  EXPECT_THAT(merged.out, HasSubstr("groups of landmarks"));
  MapFile map(both_);
  const auto sessions = map.sessions();
  ASSERT_EQ(sessions.size(), 2U);
  ASSERT_TRUE(sessions[1].T_map_session);
  EXPECT_LT(distance_between(*sessions[1].T_map_session, elsewhere().inverse()), 0.03);
  EXPECT_LT(angle_between(*sessions[1].T_map_session, elsewhere().inverse()), 0.01);
  const std::string old = folder_ / "old.lcmslam";
  leave_with_log(old);
  ASSERT_EQ(run({"merge", monday_, friday_, "--into", old, "--force"}).exit_code, 0);
  EXPECT_EQ(run({"diff", both_, old}).exit_code, 0);
  const auto out = folder_ / "view";
  ASSERT_EQ(run({"view", both_, out.string()}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(out / "fastslam-session1_top.png"));
  EXPECT_FALSE(std::filesystem::exists(out / "fastslam-session2_top.png"));
}

TEST_F(MapMerge, AMapAndItsGrownCopyAreTheGrownOne) {
  const testing_scene::LandmarkRoom room(1);
  const auto landmarks = room.mapped(Eigen::Isometry3d::Identity(), 1);
  write_landmarks(monday_, {landmarks.begin(), landmarks.begin() + 3});
  std::filesystem::copy_file(monday_, friday_);
  {
    SessionChanges grown;
    for (const Landmark& landmark : landmarks) grown.put_landmark(landmark);
    grown.drop_landmark(landmarks[0].id);
    grown.append_pose({500, Eigen::Isometry3d::Identity()});
    MapStore store(friday_);
    Transaction transaction = store.begin();
    store.write(1, grown);
    transaction.commit();
  }
  for (const auto& [first, second] : {std::pair(monday_, friday_), {friday_, monday_}, {friday_, friday_}}) {
    const auto merged = run({"merge", first, second, "--into", both_, "--force"});
    ASSERT_EQ(merged.exit_code, 0) << merged.errors;
    EXPECT_THAT(merged.out, HasSubstr("in both maps, and taken as " + friday_ + " has them: fastslam"));
    EXPECT_EQ(MapFile(both_).sessions().size(), 1U);
    EXPECT_EQ(run({"diff", both_, friday_}).exit_code, 0);
  }
}

TEST_F(MapMerge, AMapAndWhatAMergeMadeOfItAreTheMerged) {
  write_landmark_maps();
  ASSERT_EQ(run({"merge", monday_, friday_, "--into", both_}).exit_code, 0);
  const std::string again = folder_ / "again.lcmslam";
  for (const auto& [first, second] : {std::pair(friday_, both_), {both_, friday_}, {monday_, both_}}) {
    const auto merged = run({"merge", first, second, "--into", again, "--force"});
    ASSERT_EQ(merged.exit_code, 0) << merged.errors;
    EXPECT_EQ(MapFile(again).sessions().size(), 2U);
    EXPECT_EQ(run({"diff", again, both_}).exit_code, 0);
  }
}

TEST_F(MapMerge, OfTwoCopiesThatBothGrewWritesNothing) {
  write_landmark_maps();
  ASSERT_EQ(run({"merge", monday_, friday_, "--into", both_}).exit_code, 0);
  const std::string copy = folder_ / "copy.lcmslam";
  std::filesystem::copy_file(both_, copy);
  std::int64_t session = 0;
  for (const std::string& file : {both_, copy}) {
    SessionChanges driven;
    driven.append_pose({500, Eigen::Isometry3d::Identity()});
    MapStore store(file);
    Transaction transaction = store.begin();
    store.write(++session, driven);
    transaction.commit();
  }
  const auto merged = run({"merge", both_, copy, "--into", folder_ / "all.lcmslam"});
  EXPECT_NE(merged.exit_code, 0);
  EXPECT_THAT(merged.errors, HasSubstr("some newer in the first"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "all.lcmslam"));
}

TEST_F(MapMerge, ANodeWithoutCloudStaysOne) {
  write_room(monday_, 60, Eigen::Isometry3d::Identity());
  write_room(friday_, 62, elsewhere());
  {
    SessionChanges node;
    node.move_keyframe(50, 1, elsewhere(), Matrix6d(2 * Matrix6d::Identity()));
    MapStore store(friday_);
    Transaction transaction = store.begin();
    store.write(1, node);
    transaction.commit();
  }
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  MapFile map(both_);
  EXPECT_FALSE(map.cloud(2, 50));
  ASSERT_EQ(map.keyframes(2).back().id, 50);
  ASSERT_TRUE(map.keyframes(2).back().covariance);
  EXPECT_NEAR((*map.keyframes(2).back().covariance)(0, 0), 2, 1e-6);
}

// The disk takes the copy of the first map and the log of what is added, not both in one file.
TEST_F(MapMerge, OnAFullDiskKeepsTheOldMap) {
  write_room(monday_, 60, Eigen::Isometry3d::Identity());
  write_room(friday_, 62, elsewhere());
  ASSERT_EQ(run({"merge", monday_, friday_, "--into", both_}).exit_code, 0);
  const auto bytes = std::filesystem::file_size(both_);
  for (const double share : {0.3, 0.55, 0.7, 0.85, 0.95}) {
    testing::CommandRun merged;
    {
      const testing::FullDisk full(static_cast<rlim_t>(share * static_cast<double>(bytes)));
      merged = run({"merge", monday_, friday_, "--into", both_, "--force"});
    }
    EXPECT_NE(merged.exit_code, 0) << share;
    EXPECT_EQ(run({"verify", both_}).exit_code, 0) << share;
    EXPECT_EQ(MapFile(both_).sessions().size(), 2U) << share;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::filesystem::path(monday_).parent_path()))
      EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".part"))) << share;
  }
}

TEST_F(MapMerge, OfStrangersWritesNothing) {
  write_room(monday_, 60, Eigen::Isometry3d::Identity());
  write_room(friday_, 62, elsewhere(), true);
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  EXPECT_NE(merged.exit_code, 0);
  EXPECT_THAT(merged.errors, HasSubstr("no place in common"));
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(monday_).parent_path()))
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("both")));
}

// What a user called as a merge once called its file is the user's.
TEST_F(MapMerge, LeavesTheFilesOfOthersAlone) {
  write_landmark_maps();
  std::ofstream(both_ + ".part") << "notes";
  EXPECT_NE(run({"merge", monday_, strange_, "--into", both_}).exit_code, 0);
  EXPECT_EQ(std::filesystem::file_size(both_ + ".part"), 5U);
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  EXPECT_EQ(std::filesystem::file_size(both_ + ".part"), 5U);
  EXPECT_EQ(run({"verify", both_}).exit_code, 0);
  ASSERT_EQ(run({"merge", both_, friday_, "--into", both_, "--force"}).exit_code, 0) << "in its own place";
  EXPECT_EQ(MapFile(both_).sessions().size(), 2U) << "it has the second's";
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(both_).parent_path()))
    files += entry.path().filename().string().rfind("both", 0) == 0;
  EXPECT_EQ(files, 2) << "the map and the notes";
}

// Twelve hours of poses.
TEST_F(MapMerge, KeepsLongTrajectoriesWhole) {
  write_landmark_maps();
  constexpr int batches = 3, poses = 70'000;
  {
    MapStore store(friday_);
    Transaction transaction = store.begin();
    for (int batch = 0; batch < batches; ++batch) {
      SessionChanges driven;
      for (int i = 0; i < poses; ++i)
        driven.append_pose({1 + batch * poses + i, Eigen::Isometry3d::Identity()});
      store.write(1, driven);
    }
    transaction.commit();
  }
  const auto merged = run({"merge", monday_, friday_, "--into", both_});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  EXPECT_EQ(MapFile(both_).trajectory(2).size(), std::size_t{batches} * poses);
}

}  // namespace
}  // namespace lcmslam
