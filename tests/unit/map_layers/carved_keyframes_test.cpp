#include <lcmslam/map_layers/carved_keyframes.hpp>

#include <gtest/gtest.h>

#include <lcmslam/imaging/camera_model.hpp>

namespace lcmslam {
namespace {

using Eigen::Vector3f;

CameraModel camera() {
  CameraModel c;
  c.width = 320, c.height = 240;
  c.fx = c.fy = 262;
  c.cx = 159.5, c.cy = 119.5;
  return c;
}

/// A wall 2 m ahead, with a thing 1 m ahead where `thing` is true.
cv::Mat wall(bool thing) {
  cv::Mat depth(240, 320, CV_16UC1, cv::Scalar(2020));
  if (thing) depth(cv::Rect(130, 90, 60, 60)).setTo(1020);
  return depth;
}

const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
const Vector3f origin = Vector3f::Zero();
const Vector3f on_wall(0.9f, 0, 2.02f), on_thing(0, 0, 1.02f);

/// Two keyframes with a thing, and frames between them after it was taken away.
struct Carved {
  OccupancyGrid grid{OccupancySettings{}};
  CarvedKeyframes keyframes{OccupancySettings{}};
  explicit Carved(int frames_without) {
    DepthCarver carver;
    for (int id = 0; id < 3; ++id) {
      carver.carve(wall(true), camera(), here, grid);
      keyframes.add(id, wall(true), camera(), here);
    }
    for (int i = 0; i < frames_without; ++i) carver.carve(wall(false), camera(), here, grid);
  }
};

TEST(CarvedKeyframes, MoveTheMapWithTheirPoses) {
  Carved carved(0);
  const Eigen::Isometry3d moved(Eigen::Translation3d(0.4, 0, 0.2));
  const OccupancyGrid grid =
      carved.keyframes.carve_anew({{0, moved}, {1, moved}, {2, moved}}, carved.grid, origin);
  const Vector3f d(0.4f, 0, 0.2f);
  EXPECT_EQ(grid.state(Vector3f(on_wall + d)), CellState::occupied);
  EXPECT_EQ(grid.state(Vector3f(on_thing + d)), CellState::occupied);
  EXPECT_EQ(grid.state(on_wall), CellState::free);
  EXPECT_EQ(grid.state(Vector3f(0.4f, 0, 0.8f)), CellState::free);
}

// Keyframes of an older map have the highest ids, wherever they are.
TEST(CarvedKeyframes, InAFullGridWhatIsNearTheRobotStays) {
  OccupancyGrid one_view{OccupancySettings{}};
  DepthCarver().carve(wall(false), camera(), here, one_view);
  OccupancySettings settings;
  settings.max_blocks = static_cast<int>(one_view.blocks().size());
  const Eigen::Isometry3d far(Eigen::Translation3d(30, 0, 0));
  CarvedKeyframes keyframes(settings);
  keyframes.add(0, wall(false), camera(), here);
  keyframes.add(1'000'000'000, wall(false), camera(), far);
  const Vector3f far_wall = on_wall + Vector3f(30, 0, 0);
  const OccupancyGrid none(settings);
  const OccupancyGrid by_here = keyframes.carve_anew({}, none, origin);
  ASSERT_GT(by_here.forgotten(), 0U) << "it must be full";
  EXPECT_EQ(by_here.state(on_wall), CellState::occupied);
  const OccupancyGrid by_far = keyframes.carve_anew({}, none, Vector3f(30, 0, 0));
  EXPECT_EQ(by_far.state(far_wall), CellState::occupied);
  EXPECT_EQ(by_far.state(on_wall), CellState::unknown);
}

TEST(CarvedKeyframes, WhatFramesBetweenThemSawThroughDoesNotComeBack) {
  Carved carved(3);
  ASSERT_EQ(carved.grid.state(on_thing), CellState::free);
  const OccupancyGrid grid = carved.keyframes.carve_anew({}, carved.grid, origin);
  EXPECT_NE(grid.state(on_thing), CellState::occupied);
  EXPECT_EQ(grid.state(on_wall), CellState::occupied);
  // And not with the next correction either.
  const OccupancyGrid again = carved.keyframes.carve_anew({}, grid, origin);
  EXPECT_NE(again.state(on_thing), CellState::occupied);
}

// A floor seen at a slant has far fewer pixels than cells.
TEST(CarvedKeyframes, SmallImagesAreKeptWhole) {
  CameraModel tof;
  tof.width = 176, tof.height = 144;
  tof.fx = tof.fy = 200;
  tof.cx = 87.5, tof.cy = 71.5;
  cv::Mat_<std::uint16_t> floor(144, 176, std::uint16_t{0});
  for (int v = 90; v < 144; ++v) floor.row(v).setTo(1000 * 0.4 * tof.fy / (v - tof.cy));  // 0.4 m below
  OccupancyGrid grid{OccupancySettings{}};
  DepthCarver().carve(floor, tof, here, grid);
  CarvedKeyframes keyframes{OccupancySettings{}};
  keyframes.add(0, floor, tof, here);
  const OccupancyGrid again = keyframes.carve_anew({}, grid, origin);
  int cells = 0;
  for (float z = 1.1f; z < 4.2f; z += 0.04f)
    for (float x = -0.4f; x < 0.4f; x += 0.04f) {
      const Vector3f place(x, 0.4f, z);
      cells += grid.state(place) == CellState::occupied ? 1 : 0;
      EXPECT_EQ(again.state(place), grid.state(place)) << place.transpose();
    }
  EXPECT_GT(cells, 500);
}

/// Keyframe 0 sees the left half of a wall, a frame the whole wall.
cv::Mat left_half() {
  cv::Mat depth = wall(false);
  depth(cv::Rect(160, 0, 160, 240)).setTo(0);
  return depth;
}
const Vector3f on_right(0.9f, 0, 2.02f), on_left(-0.9f, 0, 2.02f);

struct Hung {
  OccupancyGrid grid{OccupancySettings{}};
  CarvedKeyframes keyframes{OccupancySettings{}};
  DepthCarver carver;
  Hung() { keep(0, left_half()); }
  void keep(int id, const cv::Mat& depth) {
    carver.carve(depth, camera(), here, grid);
    keyframes.add(id, depth, camera(), here);
  }
  void show(int hangs_on, const cv::Mat& depth, const Eigen::Isometry3d& T_map_keyframe = here) {
    carver.carve(depth, camera(), T_map_keyframe, grid);
    keyframes.follow(hangs_on, T_map_keyframe, carver.hits(), grid);
  }
};

TEST(CarvedKeyframes, WhatAFrameSawMovesWithTheKeyframeThatItHangsOn) {
  Hung hung;
  hung.show(0, wall(true));
  const Eigen::Isometry3d moved(Eigen::Translation3d(0.2, 0, 0.4));
  const Vector3f d = moved.translation().cast<float>();
  const OccupancyGrid grid = hung.keyframes.carve_anew({{0, moved}}, hung.grid, origin);
  for (const Vector3f& place : {on_left, on_right, on_thing})
    EXPECT_EQ(grid.state(Vector3f(place + d)), CellState::occupied) << place.transpose();
  EXPECT_NE(grid.state(on_right), CellState::occupied);
  // And with the next correction, further.
  const Eigen::Isometry3d on(Eigen::Translation3d(0.2, 0, 0.8));
  const OccupancyGrid again = hung.keyframes.carve_anew({{0, on}}, grid, origin);
  EXPECT_EQ(again.state(Vector3f(on_right + Vector3f(0.2f, 0, 0.8f))), CellState::occupied);
}

// Keyframes looked through where something stands now.
TEST(CarvedKeyframes, WhatCameAfterTheLastKeyframeStays) {
  Hung hung;
  for (const int id : {1, 2, 3}) hung.keep(id, wall(false));
  for (int i = 0; i < 5; ++i) hung.show(3, wall(true));
  ASSERT_EQ(hung.grid.state(on_thing), CellState::occupied);
  EXPECT_EQ(hung.keyframes.carve_anew({}, hung.grid, origin).state(on_thing), CellState::occupied);
}

TEST(CarvedKeyframes, WhatAFrameSawAndAnotherSawThroughDoesNotComeBack) {
  Hung hung;
  hung.show(0, wall(true));
  for (int i = 0; i < 3; ++i) hung.show(0, wall(false));
  ASSERT_EQ(hung.grid.state(on_thing), CellState::free);
  const OccupancyGrid grid = hung.keyframes.carve_anew({}, hung.grid, origin);
  EXPECT_NE(grid.state(on_thing), CellState::occupied);
  EXPECT_EQ(grid.state(on_right), CellState::occupied);
}

// The graph has moved the keyframe, and space is not carved anew yet.
TEST(CarvedKeyframes, FramesAreKeptFromWhereTheKeyframeStandsByNow) {
  Hung hung;
  const Eigen::Isometry3d by_now(Eigen::Translation3d(0, 0, 0.4));
  hung.show(0, wall(false), by_now);
  const OccupancyGrid grid =
      hung.keyframes.carve_anew({{0, by_now}}, OccupancyGrid(OccupancySettings{}), origin);
  EXPECT_EQ(grid.state(Vector3f(on_right + Vector3f(0, 0, 0.4f))), CellState::occupied);
  EXPECT_NE(grid.state(Vector3f(on_right + Vector3f(0, 0, 0.8f))), CellState::occupied);
}

TEST(CarvedKeyframes, ACellIsKeptOnceAndNotAtAllWhereAKeyframeSeesIt) {
  Hung hung;
  hung.show(0, left_half());
  EXPECT_LT(hung.keyframes.cells_of_frames(), 50U);  // at the rim
  hung.show(0, wall(false));
  const std::size_t right = hung.keyframes.cells_of_frames();
  EXPECT_GT(right, 1000U);
  hung.show(0, wall(false));
  EXPECT_EQ(hung.keyframes.cells_of_frames(), right);
  hung.keep(1, wall(false));
  hung.show(1, wall(false));
  EXPECT_LT(hung.keyframes.cells_of_frames(), right / 10);
}

// Who stands still and looks at what moves does not remember it all.
TEST(CarvedKeyframes, WhatMovesThroughAViewIsNotKept) {
  Hung hung;
  for (int i = 0; i < 60; ++i) hung.show(0, cv::Mat(240, 320, CV_16UC1, cv::Scalar(1000 + 40 * i)));
  EXPECT_LT(hung.keyframes.cells_of_frames(), 70'000U);  // of 218,000
  EXPECT_EQ(hung.grid.state(Vector3f(0.9f, 0, 3.36f)), CellState::occupied);
}

TEST(CarvedKeyframes, AreBounded) {
  OccupancySettings settings;
  settings.max_keyframes = 2;
  CarvedKeyframes keyframes(settings);
  for (int id = 0; id < 5; ++id) keyframes.add(id, wall(false), camera(), here);
  EXPECT_EQ(keyframes.size(), 2U);
  EXPECT_EQ(keyframes.forgotten(), 3U);
  EXPECT_LT(keyframes.memory_bytes(), 2U * 40'000U);
  keyframes.forget(4);
  keyframes.forget(77);
  EXPECT_EQ(keyframes.size(), 1U);
}

}  // namespace
}  // namespace lcmslam
