// Maps whose images were taken by more than one calibration of a sensor.

#include <gmock/gmock.h>

#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include "tests/support/landmark_room.hpp"
#include "tests/support/seen_kitchen.hpp"
#include "tests/unit/map_store_file/sample_store.hpp"
#include "tests/unit/tools/command_run.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

using ::testing::HasSubstr;

class MapCameras : public ::testing::Test {
 protected:
  static testing::SimulatedKitchen& kitchen() { return testing::SimulatedKitchen::instance(); }
  testing::CommandRun run(std::vector<std::string> arguments) {
    return testing::run_command({"map", map_command}, std::move(arguments));
  }
  std::string file(const std::string& name) const { return folder_ / (name + ".lcmslam"); }

  static std::shared_ptr<const StoredCalibration> stored(const RgbdCalibration& calibration) {
    return std::make_shared<StoredCalibration>(StoredCalibration{
        calibration.sensor, camera_calibration_t::getTypeName(), encode_message(to_message(calibration))});
  }
  /// The kitchen's head, and the same with every second pixel of its depth images alone.
  static RgbdCalibration head() { return kitchen().simulation().calibration(); }
  static RgbdCalibration half_head() {
    RgbdCalibration half = head();
    half.depth.width /= 2;
    half.depth.height /= 2;
    for (double* number : {&half.depth.fx, &half.depth.fy, &half.depth.cx, &half.depth.cy}) *number /= 2;
    return half;
  }
  /// A view of the kitchen from its true place, as head() or half_head() takes it.
  static void put_view(SessionChanges& changes, int id, bool half) {
    const testing::SeenView& view = testing::seen_view(60 + 5 * id);
    changes.put_keyframe({id, view.features.utime, view.T_world_camera, view.cloud, 0}, std::nullopt);
    StoredImages images;
    images.frame = from_message(*view.images);
    const Utime depth_time = head().depth_time(images.frame.depth.utime);
    images.T_colour_depth_time = view.T_world_camera.inverse() *
                                 kitchen().simulation().T_world_robot(depth_time) * head().T_robot_camera;
    if (half) {
      const cv::Mat depth = decode_images(images.frame, head()).depth;
      cv::Mat small(depth.rows / 2, depth.cols / 2, CV_16UC1);
      for (int v = 0; v < small.rows; ++v)
        for (int u = 0; u < small.cols; ++u)
          small.at<std::uint16_t>(v, u) = depth.at<std::uint16_t>(2 * v, 2 * u);
      images.frame.depth = encode_depth(small, images.frame.depth.utime);
    }
    images.frame.amplitude = {};
    images.calibration = stored(half ? half_head() : head());
    changes.put_images(id, images);
  }
  static double median_error(const ColouredCloud& cloud) {
    std::vector<double> errors;
    for (const Eigen::Vector3f& point : cloud.points)
      errors.push_back(std::abs(kitchen().simulation().distance_to_surface(point.cast<double>())));
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
  }

  TemporaryFolder folder_;
};

// The second view begins with the head's other calibration, in one session; then another robot's is told.
TEST_F(MapCameras, ExportsReadEachImageByItsOwn) {
  const std::string map = file("kitchen");
  for (const bool other_first : {false, true}) {
    std::filesystem::remove(map);
    {
      SessionChanges changes;
      put_view(changes, 0, other_first);
      put_view(changes, 1, !other_first);
      MapStore store(map);
      Transaction transaction = store.begin();
      store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp")), changes);
      RgbdCalibration stranger = head();
      stranger.depth.fx *= 1.5;
      store.put_calibration(*stored(stranger));
      transaction.commit();
    }
    const auto out = folder_ / "out";
    const std::vector<std::string> pixels = {"export",   map,       out.string(),   "--formats", "ply",
                                             "--images", "--force", "--resolution", "0.005"};
    const auto exported = run(pixels);
    ASSERT_EQ(exported.exit_code, 0) << exported.errors;
    const ColouredCloud cloud = load_ply(out / "icp-session1_map.ply");
    EXPECT_GT(cloud.size(), 12'000U);
    EXPECT_LT(cloud.size(), 176U * 144 * 5 / 4);
    EXPECT_LT(median_error(cloud), 0.01);

    const auto derived = run({"export", map, out.string(), "--formats", "mesh,octomap", "--force"});
    ASSERT_EQ(derived.exit_code, 0) << derived.errors;
    const ColouredCloud mesh = load_ply(out / "icp-session1_mesh.ply");
    EXPECT_GT(mesh.size(), 3'000U);
    EXPECT_LT(median_error(mesh), 0.02);
  }
}

// A live map keeps what is near in a bound that a robot bears; what is exported is all there.
TEST_F(MapCameras, TheMeshOfAWideMapIsWhole) {
  constexpr int places = 32;
  constexpr double apart = 32;  // m, of so many blocks of voxels: the places are seen alike
  const EncodedFrame frame = from_message(kitchen().frame(60));
  SessionChanges changes;
  for (int id = 0; id < places; ++id) {
    changes.move_keyframe(id, frame.utime + id,
                          Eigen::Isometry3d(Eigen::Translation3d(apart * id, 0, 0) * optical_axes()));
    StoredImages images{frame, Eigen::Isometry3d::Identity()};
    images.calibration = stored(head());
    changes.put_images(id, images);
  }
  {
    MapStore store(file("wide"));
    Transaction transaction = store.begin();
    store.put_calibration(*stored(head()));
    store.write(store.add_session(store.add_run({"1.2", ""}), session_of("icp")), changes);
    transaction.commit();
  }
  const TemporaryFolder out;
  const auto exported = run({"export", file("wide"), out / "mesh", "--formats", "mesh"});
  ASSERT_EQ(exported.exit_code, 0) << exported.errors;
  const ColouredCloud mesh = load_ply(out / "mesh/icp-session1_mesh.ply");
  const auto vertices_at = [&](int place) {
    return std::count_if(mesh.points.begin(), mesh.points.end(), [&](const Eigen::Vector3f& point) {
      return std::abs(static_cast<double>(point.x()) - apart * place) < apart / 2;
    });
  };
  EXPECT_GT(vertices_at(places - 1), 3000);
  for (int place = 0; place < places; ++place)
    EXPECT_NEAR(static_cast<double>(vertices_at(place)) / static_cast<double>(vertices_at(places - 1)), 1,
                0.05)
        << place;
}

TEST_F(MapCameras, MergedMapsKeepTheirOwn) {
  const testing_scene::LandmarkRoom room(1);
  const auto write = [&](const std::string& name, const std::vector<Landmark>& landmarks,
                         std::uint8_t calibration) {
    SessionChanges sparse, dense;
    for (const Landmark& landmark : landmarks) sparse.put_landmark(landmark);
    dense.put_keyframe(some_keyframe(1), std::nullopt);
    StoredImages images = some_images(1);
    images.calibration =
        std::make_shared<StoredCalibration>(StoredCalibration{"head", "form", {calibration}});
    dense.put_images(1, images);
    MapStore store(file(name));
    Transaction transaction = store.begin();
    store.put_calibration(*images.calibration);
    const std::int64_t written = store.add_run({"1.2", ""});
    store.write(store.add_session(written, session_of("fastslam", calibration)), sparse);
    store.write(store.add_session(written, session_of("icp", calibration)), dense);
    store.put_calibration({"head", "form", {static_cast<std::uint8_t>(calibration + 1)}});
    transaction.commit();
  };
  const auto expect = [&](const std::string& name, std::uint8_t first, std::uint8_t second) {
    MapFile map(file(name));
    EXPECT_EQ(map.images(2, 1).value().calibration->bytes, std::vector<std::uint8_t>{first});
    EXPECT_EQ(map.images(4, 1).value().calibration->bytes, std::vector<std::uint8_t>{second});
    EXPECT_EQ(run({"verify", file(name)}).exit_code, 0);
  };
  write("monday", room.mapped(Eigen::Isometry3d::Identity(), 1), 10);
  write("friday", room.mapped(Eigen::Isometry3d::Identity(), 2), 20);
  const auto merged = run({"merge", file("monday"), file("friday"), "--into", file("both")});
  ASSERT_EQ(merged.exit_code, 0) << merged.errors;
  expect("both", 10, 20);
  EXPECT_THAT(run({"info", file("both")}).out, HasSubstr("2 calibrations of head"));

  // Both of an older lcmslam, which knew what was told last.
  for (const char* day : {"monday", "friday"})
    Database(file(day), Database::Access::write)
        .execute("ALTER TABLE images DROP COLUMN camera; DROP TABLE camera; PRAGMA user_version = 3");
  ASSERT_EQ(run({"merge", file("monday"), file("friday"), "--into", file("old")}).exit_code, 0);
  expect("old", 11, 21);
  EXPECT_EQ(MapFile(file("monday")).schema(), 3) << "it stays as it is";
}

}  // namespace
}  // namespace lcmslam
