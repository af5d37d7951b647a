#include "procs/map-server/layer_worker.hpp"

#include <gtest/gtest.h>

#include <lcmslam/imaging/io/codec.hpp>

namespace lcmslam {
namespace {

LayerWorker::Calibration some_camera() {
  static const LayerWorker::Calibration camera = [] {
    RgbdCalibration calibration;
    calibration.colour = calibration.depth = CameraModel{160, 120, 140, 140, 79.5, 59.5, {}};
    calibration.depth_registered = true;
    return std::make_shared<RgbdCalibration>(calibration);
  }();
  return camera;
}

/// 2 m away.
LayerWorker::Images wall() {
  RgbdFrame frame;
  frame.depth = cv::Mat(120, 160, CV_16UC1, cv::Scalar(2000));
  frame.depth.at<std::uint16_t>(0, 0) = 2001;  // one single value would be no depth at all
  frame.colour = cv::Mat(120, 160, CV_8UC3, cv::Scalar(50, 100, 150));
  return {std::make_shared<EncodedFrame>(encode(frame)), some_camera()};
}

/// Looks along x.
FramePose at(double x) {
  return {Eigen::Translation3d(x, 0, 1) * optical_axes(), Eigen::Isometry3d::Identity()};
}

LiveMapSettings settings(bool background, int refit_every) {
  LiveMapSettings s;
  s.background = background;
  s.refit_every = refit_every;
  s.surface.voxel_size = 0.04;
  s.surface.coarse_voxel_size = 0.16;
  return s;
}

/// Where the surface stands, m.
double mean_x(const Mesh& mesh) {
  double sum = 0;
  for (const Eigen::Vector3f& v : mesh.vertices) sum += static_cast<double>(v.x());
  return sum / static_cast<double>(mesh.vertices.size());
}

double mean_x(const LayerWorker& worker) {
  return mean_x(worker.map()->mesh());
}

TEST(LayerWorker, WhileFramesComeTheSurfaceFollowsTheGraphNowAndThen) {
  LayerWorker worker(settings(false, 3));
  worker.begin_map(some_camera());
  worker.keep(1, wall(), at(0));
  EXPECT_NEAR(mean_x(worker), 2, 0.02);  // from now on somebody looks
  worker.correct({{1, at(0.2).T_map_camera}});
  EXPECT_NEAR(mean_x(worker), 2, 0.02);
  worker.correct({{1, at(0.4).T_map_camera}});
  EXPECT_NEAR(mean_x(worker), 2.4, 0.02);
  worker.show(wall(), at(0.4), false);
  worker.correct({{1, at(0.1).T_map_camera}});
  EXPECT_NEAR(mean_x(worker), 2.4, 0.02);
  worker.settle(std::chrono::seconds(0));  // as before a map is saved
  EXPECT_NEAR(mean_x(worker), 2.1, 0.02);
}

TEST(LayerWorker, ASurfaceThatNobodyLooksAtFollowsWhenSomebodyDoes) {
  LiveMapSettings resting = settings(false, 1);
  resting.surface_rest = 2;
  LayerWorker worker(resting);
  worker.begin_map(some_camera());
  worker.keep(1, wall(), at(0));
  EXPECT_NEAR(mean_x(worker), 2, 0.02);
  for (int frame = 0; frame < 3; ++frame) worker.show(wall(), at(0), false);
  worker.correct({{1, at(0.2).T_map_camera}});
  EXPECT_EQ(worker.map()->haste(), LiveMap::Haste::none);
  double moved = 0;  // of who follows it: of the last keyframe
  const auto see = [&](const MeshCube&, const Mesh& mesh) {
    for (const Eigen::Vector3f& v : mesh.vertices) moved = std::max(moved, static_cast<double>(v.x()));
  };
  worker.map()->changed_mesh(0, see);
  EXPECT_NEAR(moved, 2, 0.04) << "nothing was done while nobody looked";
  EXPECT_EQ(worker.map()->haste(), LiveMap::Haste::much);
  worker.show(wall(), at(0), false);  // there is time after it
  EXPECT_EQ(worker.map()->haste(), LiveMap::Haste::some);
  worker.map()->changed_mesh(0, see);
  EXPECT_NEAR(moved, 2.2, 0.04);

  for (int frame = 0; frame < 3; ++frame) worker.show(wall(), at(0), false);
  worker.correct({{1, at(0.4).T_map_camera}});
  EXPECT_NEAR(mean_x(worker.map()->settled_mesh()), 2.4, 0.02);
  EXPECT_EQ(worker.map()->haste(), LiveMap::Haste::none) << "saving is not watching";
  worker.correct({{1, at(0.1).T_map_camera}});
  EXPECT_NEAR(mean_x(worker), 2.1, 0.02) << "who asks after a while waits";
}

TEST(LayerWorker, WhenNoMoreFramesComeAllOfItDoes) {
  LayerWorker worker(settings(true, 1000));
  worker.begin_map(some_camera());
  worker.keep(1, wall(), at(0));
  worker.keep(2, wall(), at(0));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const auto wait_for = [&](const auto& arrived) {
    while (!arrived() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  };
  wait_for([&] { return worker.state().kept == 2; });
  EXPECT_NEAR(mean_x(worker), 2, 0.02);  // from now on somebody looks
  worker.correct({{1, at(0.4).T_map_camera}, {2, at(0.4).T_map_camera}});
  wait_for([&] { return std::abs(mean_x(worker) - 2.4) < 0.02; });
  EXPECT_NEAR(mean_x(worker), 2.4, 0.02);
}

CellState state(const LayerWorker& worker, double x) {
  return worker.map()->space().ask_occupied([&](const OccupancyGrid& occupied) {
    return occupied.state(Eigen::Vector3f(static_cast<float>(x), 0, 1));
  });
}

TEST(LayerWorker, WhenNoMoreFramesComeSpaceFollowsTheGraph) {
  LayerWorker worker(settings(true, 1000));
  worker.begin_map(some_camera());
  const auto stand_at = [](double x) {
    std::map<int, Eigen::Isometry3d> poses;
    for (int i = 0; i < 10; ++i) poses[i] = at(10 * i + x).T_map_camera;
    return poses;
  };
  for (int i = 0; i < 10; ++i) worker.keep(i, wall(), at(10 * i));
  worker.correct(stand_at(0.2));
  worker.settle(std::chrono::seconds(60));
  ASSERT_EQ(state(worker, 2.2), CellState::occupied);
  worker.correct(stand_at(0.4));
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (state(worker, 2.4) != CellState::occupied && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(state(worker, 2.4), CellState::occupied);
}

TEST(LayerWorker, NoKeyframeIsLeftOutHoweverManyWait) {
  LayerWorker worker(settings(true, 1000));
  worker.begin_map(some_camera());
  ColouredCloud point;
  point.points = {{0, 0, 1}};
  point.colours = {{0, 0, 0}};
  constexpr int keyframes = 1000, corrections = 20;
  std::map<int, Eigen::Isometry3d> whole;
  for (int i = 0; i < keyframes; ++i) {
    whole[i] = at(0.1 * i).T_map_camera;
    worker.keep(i, point, whole[i], LiveMap::When::before);
  }
  for (int i = 0; i < corrections; ++i) worker.follow(whole);
  EXPECT_EQ(worker.state().left_out, corrections - 1) << "of these the last counts";
  worker.settle(std::chrono::seconds(300));
  EXPECT_EQ(worker.state().imageless, keyframes);
}

// What was seen before may wait; what moves it must not come before it.
TEST(LayerWorker, CorrectionsFindWhatTheyMove) {
  for (int round = 0; round < 20; ++round) {
    LayerWorker worker(settings(true, 1000));
    worker.begin_map(some_camera());
    for (int i = 0; i < 3; ++i) worker.keep(i, wall(), at(10 * i), LiveMap::When::before);
    worker.correct({{0, at(0.4).T_map_camera}, {1, at(10.4).T_map_camera}, {2, at(20.4).T_map_camera}});
    worker.adopt(1000, wall(), at(50));
    worker.move_adopted({{1000, at(50.4).T_map_camera}});
    worker.settle(std::chrono::seconds(60));
    for (const double x : {2.4, 12.4, 22.4, 52.4}) EXPECT_EQ(state(worker, x), CellState::occupied) << x;
  }
}

}  // namespace
}  // namespace lcmslam
