#include <gmock/gmock.h>

#include <fstream>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tests/unit/tools/map_command_fixture.hpp"

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::MapCommand;
using ::testing::Not;

TEST_F(MapCommand, InfoIsOneScreen) {
  const auto info = run({"info", file()});
  EXPECT_EQ(info.exit_code, 0) << info.errors;
  EXPECT_THAT(info.out, AllOf(HasSubstr("schema " + std::to_string(newest_schema)), HasSubstr("version 1.2"),
                              ContainsRegex("icp-session2 +4 +200 "), ContainsRegex("fastslam-session1 +0")));
  EXPECT_THAT(run({"info", file(), "--json"}).out,
              AllOf(HasSubstr("\"name\": \"icp-session1\""), HasSubstr("\"landmarks\": 7")));
}

TEST_F(MapCommand, InfoTellsNodesWithoutACloudFromKeyframes) {
  EXPECT_THAT(run({"info", file()}).out, Not(HasSubstr("that have a cloud")));
  Database(file(), Database::Access::write).execute("DELETE FROM cloud WHERE session = 2 AND keyframe = 1");
  EXPECT_THAT(run({"info", file()}).out,
              AllOf(ContainsRegex("icp-session2 +3 +150 +0 +4 "), HasSubstr("nodes that have a cloud")));
  EXPECT_THAT(run({"verify", file()}).out, HasSubstr("7 nodes (6 keyframes with a cloud)"));
}

TEST_F(MapCommand, ExportsWhatOthersRead) {
  const auto out = folder_ / "out";
  const auto exported = run({"export", file(), out, "--resolution", "0"});
  EXPECT_EQ(exported.exit_code, 0);
  EXPECT_THAT(exported.out, HasSubstr("icp-session1_trajectory_times.txt\n"));
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

TEST_F(MapCommand, AnExportThatWritesNothingSaysSo) {
  const auto out = folder_ / "out";
  const auto nothing = run({"export", file(), out, "--sessions", "icp-session1", "--formats", "csv,octomap"});
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.errors, AllOf(HasSubstr("nothing was written"), HasSubstr("csv, octomap")));
  EXPECT_EQ(run({"export", file(), out, "--formats", "csv"}).exit_code, 0) << "of fastslam's session";
  std::ofstream(folder_ / "empty.lcmslam").close();
  EXPECT_EQ(run({"export", folder_ / "empty.lcmslam", out}).exit_code, 1);
}

// From the images of two keyframes: what is derived stands where the kitchen's surfaces are.
TEST_F(MapCommand, ExportsWhatIsDerivedFromImages) {
  testing::SimulatedKitchen& kitchen = testing::SimulatedKitchen::instance();
  const RgbdCalibration calibration = kitchen.simulation().calibration();
  SessionChanges changes;
  for (const int id : {0, 1}) {
    const EncodedFrame frame = from_message(kitchen.frame(60 + 5 * id));
    const auto T_world_camera = [&](Utime at) {
      return kitchen.simulation().T_world_robot(at) * calibration.T_robot_camera;
    };
    changes.move_keyframe(id, frame.utime, T_world_camera(frame.utime));
    const Utime depth_time = calibration.depth_time(frame.depth.utime);
    changes.put_images(id, {frame, T_world_camera(frame.utime).inverse() * T_world_camera(depth_time)});
    changes.append_pose({frame.utime, kitchen.simulation().T_world_robot(frame.utime)});
  }
  const auto map = folder_ / "images.lcmslam";
  {
    MapStore store(map);
    Transaction transaction = store.begin();
    store.put_calibration(
        {calibration.sensor, camera_calibration_t::getTypeName(), encode_message(kitchen.calibration())});
    store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp")), changes);
    transaction.commit();
  }
  const auto out = folder_ / "out";
  EXPECT_EQ(run({"export", map.string(), out.string(), "--formats", "mesh,octomap,grid"}).exit_code, 0);
  for (const char* name : {"mesh.ply", "mesh.obj", "mesh.glb", "space.bt", "grid.pgm", "grid.yaml"})
    EXPECT_GT(std::filesystem::file_size(out / ("icp-session1_" + std::string(name))), 100U) << name;
  const auto median_error = [&](const ColouredCloud& cloud) {
    std::vector<double> errors;
    for (const Eigen::Vector3f& point : cloud.points)
      errors.push_back(std::abs(kitchen.simulation().distance_to_surface(point.cast<double>())));
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
  };
  const ColouredCloud mesh = load_ply(out / "icp-session1_mesh.ply");
  ASSERT_GT(mesh.size(), 10'000U);
  EXPECT_LT(median_error(mesh), 0.01);

  // Nobody told a cloud of these keyframes; every pixel that is used makes a point.
  const std::vector<std::string> pixels = {"export", map.string(), out.string(),   "--formats",
                                           "ply",    "--images",   "--resolution", "0.005"};
  EXPECT_EQ(run(pixels).exit_code, 0);
  const ColouredCloud cloud = load_ply(out / "icp-session1_map.ply");
  EXPECT_GT(cloud.size(), 20'000U);
  EXPECT_LT(cloud.size(), 2U * 176 * 144);
  EXPECT_LT(median_error(cloud), 0.01);
}

// Keyframe 0 was told with normals, 1 without, 2 is there as images, and all in the other order.
TEST_F(MapCommand, ExportsKeyframesWithImagesBesideThoseWithout) {
  testing::SimulatedKitchen& kitchen = testing::SimulatedKitchen::instance();
  const RgbdCalibration calibration = kitchen.simulation().calibration();
  const EncodedFrame frame = from_message(kitchen.frame(60));
  for (const bool images_first : {false, true}) {
    SessionChanges changes;
    const int with_images = images_first ? 0 : 2;
    for (int id = 0; id < 3; ++id) {
      if (id == with_images) {
        changes.move_keyframe(id, frame.utime, Eigen::Isometry3d::Identity());
        changes.put_images(id, {frame, Eigen::Isometry3d::Identity()});
        continue;
      }
      DenseKeyframe told = some_keyframe(id, 2000);
      if (id == 1) told.cloud.normals.clear();
      if (id != 1) told.cloud.normals.assign(2000, Eigen::Vector3f(0, 0, -1));
      told.cloud.sigmas.clear();
      told.T_world_camera = Eigen::Translation3d(100 * (id + 1), 0, 0);
      changes.put_keyframe(told, std::nullopt);
    }
    const auto map = folder_ / (images_first ? "first.lcmslam" : "last.lcmslam");
    {
      MapStore store(map);
      Transaction transaction = store.begin();
      store.put_calibration(
          {calibration.sensor, camera_calibration_t::getTypeName(), encode_message(kitchen.calibration())});
      store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp")), changes);
      transaction.commit();
    }
    const auto out = folder_ / (images_first ? "first" : "last");
    const auto exported =
        run({"export", map.string(), out.string(), "--formats", "ply", "--images", "--resolution", "0.005"});
    ASSERT_EQ(exported.exit_code, 0) << exported.errors;
    const ColouredCloud cloud = load_ply(out / "icp-session1_map.ply");
    const auto far = std::count_if(cloud.points.begin(), cloud.points.end(),
                                   [](const Eigen::Vector3f& point) { return point.x() > 50; });
    EXPECT_GT(far, 1000) << "of what was told";
    EXPECT_GT(cloud.size(), static_cast<std::size_t>(far) + 10'000U) << "and of the images";
    EXPECT_EQ(cloud.normals.size(), cloud.size());
  }
}

TEST_F(MapCommand, ViewDrawsEachFrameAlone) {
  const auto out = folder_ / "view";
  EXPECT_EQ(run({"view", file().string(), out.string()}).exit_code, 0);
  for (const char* name : {"icp-session1", "icp-session2", "fastslam-session1"}) {
    EXPECT_TRUE(std::filesystem::exists(out / (std::string(name) + "_front.png"))) << name;
    EXPECT_TRUE(std::filesystem::exists(out / (std::string(name) + "_top.png"))) << name;
  }
  EXPECT_NE(run({"view", file().string(), out.string()}).exit_code, 0) << "nothing is overwritten unasked";
}

TEST_F(MapCommand, ViewDrawsJoinedSessionsTogether) {
  {
    MapStore store(file());
    Transaction transaction = store.begin();
    StoredSession joined = session_of("icp");
    joined.id = 2;
    joined.state = SessionState::joined;
    joined.T_map_session = Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0));
    store.place_session(joined);
    transaction.commit();
  }
  const auto out = folder_ / "view";
  EXPECT_EQ(run({"view", file().string(), out.string()}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(out / "icp-session1_top.png"));
  EXPECT_FALSE(std::filesystem::exists(out / "icp-session2_top.png"));
}

}  // namespace
}  // namespace lcmslam
