#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/surface/surface.hpp>
#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

using testing_scene::render;
using Room = testing_scene::Scene;

RgbdCalibration camera_head() {
  RgbdCalibration calibration;
  calibration.colour = {160, 120, 140, 140, 79.5, 59.5, {}};
  calibration.depth_registered = true;
  calibration.depth_noise = {0.002, 0, 0, 0};
  return calibration;
}

/// A wall 1.5 m away and a box before it, in the first camera's frame.
Room room() {
  return {{{{0, 0, 1}, 1.5}},
          {Eigen::AlignedBox3d(Eigen::Vector3d(-0.2, -0.15, 1.1), Eigen::Vector3d(0.1, 0.15, 1.3))}};
}

RgbdFrame frame_of(const Room& scene, const Eigen::Isometry3d& T, const cv::Scalar& colour = {20, 60, 200}) {
  RgbdFrame frame;
  frame.depth = render(scene, camera_head().colour, T);
  frame.colour = cv::Mat(frame.depth.size(), CV_8UC3, colour);
  return frame;
}

Eigen::Isometry3d pose(double x, double y, double turn) {
  return Eigen::Translation3d(x, y, 0) * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY());
}

const std::vector<Eigen::Isometry3d>& poses() {
  static const std::vector<Eigen::Isometry3d> all = {pose(0, 0, 0), pose(0.2, 0.05, -0.15),
                                                     pose(-0.2, 0, 0.15)};
  return all;
}

SurfaceSettings settings() {
  SurfaceSettings s;
  s.moved_distance = 1e-4;
  return s;
}

double off_surface(const Room& scene, const Eigen::Vector3f& point) {
  const Eigen::Vector3d p = point.cast<double>();
  double nearest = std::abs(1.5 - p.z());
  for (const auto& box : scene.boxes) {
    const Eigen::Vector3d inside = (p - box.min()).cwiseMin(box.max() - p);
    nearest = std::min(nearest, inside.minCoeff() > 0 ? inside.minCoeff() : box.exteriorDistance(p));
  }
  return nearest;
}

TEST(Surface, WhatKeyframesSawStandsAtTheirNewestPoses) {
  Surface surface(camera_head(), settings());
  for (std::size_t i = 0; i < 2; ++i)
    surface.fuse(static_cast<std::int64_t>(i), frame_of(room(), poses()[i]), poses()[i]);
  const ColouredCloud cloud = surface.cloud({0, 1}, 0.005);
  ASSERT_GT(cloud.size(), 10000u);
  EXPECT_GT(cloud.size(), surface.cloud({0}, 0.005).size());
  std::vector<double> off;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    off.push_back(off_surface(room(), cloud.points[i]));
    EXPECT_LT(cv::norm(cloud.colours[i], cv::Vec3b(20, 60, 200), cv::NORM_INF), 8) << "as JPEG keeps it";
  }
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() * 95 / 100], 2e-3);
  surface.move(1, poses()[1] * Eigen::Translation3d(0, 0, -0.3));
  const ColouredCloud moved = surface.cloud({1}, 0.005);
  double nearest = 10;
  for (const Eigen::Vector3f& p : moved.points) nearest = std::min(nearest, static_cast<double>(p.z()));
  EXPECT_NEAR(nearest, 0.8, 0.03) << "the box stands at 1.1 m";
}

TEST(Surface, StandsWhereTheSurfacesStand) {
  Surface surface(camera_head(), settings());
  for (std::size_t i = 0; i < poses().size(); ++i)
    surface.fuse(static_cast<std::int64_t>(i), frame_of(room(), poses()[i]), poses()[i]);
  const Mesh mesh = surface.mesh();
  ASSERT_GT(mesh.vertices.size(), 10000u);
  std::vector<double> off;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    off.push_back(off_surface(room(), mesh.vertices[i]));
    EXPECT_EQ(mesh.colours[i], cv::Vec3b(20, 60, 200));
  }
  std::sort(off.begin(), off.end());
  EXPECT_LT(off[off.size() / 2], 5e-4);
  EXPECT_LT(off[off.size() * 95 / 100], 2e-3);
  // The box's rim may be blunt, but nothing hangs between the box and the wall.
  EXPECT_LT(off[off.size() * 999 / 1000], 0.012);
}

/// No plane fits a bar that is one pixel wide: its looks count little, but are there.
TEST(Surface, ShowsWhatIsTooThinForNormals) {
  const Room bar{
      {{{0, 0, 1}, 3.3}},
      {Eigen::AlignedBox3d(Eigen::Vector3d(-0.0025, -0.3, 2.8), Eigen::Vector3d(0.0165, 0.3, 2.82))}};
  Surface surface(camera_head(), settings());
  for (int i = 0; i < 6; ++i) {
    const Eigen::Isometry3d T = pose(-0.003, 0.002 * i, 0);
    surface.fuse(i, frame_of(bar, T), T);
  }
  std::array<bool, 50> shown{};  // along the bar
  for (const Eigen::Vector3f& p : surface.mesh().vertices)
    if (std::abs(p.z() - 2.8f) < 0.02f && std::abs(p.y()) < 0.25f)
      shown[static_cast<std::size_t>((p.y() + 0.25f) * 100)] = true;
  EXPECT_GT(std::count(shown.begin(), shown.end(), true), 45);
}

std::vector<Eigen::Vector3f> fused_after(const std::vector<Eigen::Isometry3d>& wrong) {
  Surface surface(camera_head(), settings());
  for (std::size_t i = 0; i < poses().size(); ++i)
    surface.fuse(static_cast<std::int64_t>(i), frame_of(room(), poses()[i]), wrong[i]);
  surface.mesh();
  for (std::size_t i = 0; i < poses().size(); ++i) surface.move(static_cast<std::int64_t>(i), poses()[i]);
  int left = 3;
  for (int cycle = 0; left > 0 && cycle < 5; ++cycle) left = surface.refuse(1);
  EXPECT_EQ(left, 0);
  return surface.mesh().vertices;
}

TEST(Surface, WhereTheGraphBendsNoSecondWallStays) {
  std::vector<Eigen::Isometry3d> wrong = poses();
  wrong[1] = wrong[1] * pose(0.03, 0.02, 0.05);
  wrong[2].translation().z() -= 0.06;
  for (const Eigen::Vector3f& vertex : fused_after(wrong)) ASSERT_LT(off_surface(room(), vertex), 0.025);
  const std::size_t right = fused_after(poses()).size();
  EXPECT_NEAR(static_cast<double>(fused_after(wrong).size()), static_cast<double>(right),
              0.002 * static_cast<double>(right));
}

TEST(Surface, WhatWaitsIsFusedWhereTheGraphHasBentIt) {
  Surface waiting(camera_head(), settings()), right(camera_head(), settings());
  for (std::size_t i = 0; i < poses().size(); ++i) {
    const auto id = static_cast<std::int64_t>(i);
    right.fuse(id, frame_of(room(), poses()[i]), poses()[i]);
    waiting.hand_in(id, frame_of(room(), poses()[i]), poses()[i] * pose(0.03, 0.02, 0.05));
    waiting.move(id, poses()[i]);
  }
  EXPECT_EQ(waiting.fine().size(), 0u);
  EXPECT_EQ(waiting.cloud({0, 1, 2}, 0.005).size(), right.cloud({0, 1, 2}, 0.005).size());
  const Mesh mesh = waiting.mesh();
  EXPECT_EQ(mesh.vertices, right.mesh().vertices) << "to the bit";
  EXPECT_EQ(waiting.refuse(10), 0);
}

/// But for roundings of what was put in and taken out again; and no empty block is left.
void expect_same_voxels(const VoxelBlocks& a, const VoxelBlocks& b) {
  constexpr int roundings = 5;
  std::size_t filled = 0;
  for (const VoxelBlocks::Entry& entry : b.entries()) {
    if (is_empty(*entry.block)) continue;
    ++filled;
    const std::int32_t found = a.find(entry.at);
    ASSERT_GE(found, 0);
    const VoxelBlock& other = *a.entries()[static_cast<std::size_t>(found)].block;
    for (std::size_t i = 0; i < std::size(other.weight); ++i) {
      ASSERT_EQ(other.weight[i], entry.block->weight[i]);
      ASSERT_NEAR(other.distance[i], entry.block->distance[i], roundings);
    }
  }
  EXPECT_EQ(a.size(), filled);
}

TEST(Surface, WhatIsForgottenIsTakenOut) {
  const Eigen::Isometry3d elsewhere = pose(0, 0, -0.9);
  Surface surface(camera_head(), settings()), without(camera_head(), settings());
  for (const std::int64_t id : {0, 2, 1}) {  // the later sees into blocks that the earlier made
    const Eigen::Isometry3d& T = id == 1 ? elsewhere : poses()[static_cast<std::size_t>(id)];
    surface.fuse(id, frame_of(room(), T), T);
    if (id != 1) without.fuse(id, frame_of(room(), T), T);
  }
  const std::size_t vertices = surface.mesh().vertices.size();
  surface.hand_in(3, frame_of(room(), elsewhere), elsewhere);
  surface.forget(3);  // while it waits
  surface.forget(1);
  surface.forget(77);
  EXPECT_EQ(surface.mesh().vertices.size(), vertices) << "when there is time";
  EXPECT_EQ(surface.refuse(0), 1);
  EXPECT_EQ(surface.refuse(1), 0);
  expect_same_voxels(surface.fine(), without.fine());
  expect_same_voxels(surface.coarse(), without.coarse());
  EXPECT_EQ(surface.cloud({0, 1, 2, 3}, 0.005).size(), without.cloud({0, 2}, 0.005).size());
  surface.fuse(1, frame_of(room(), elsewhere), elsewhere);
  EXPECT_GT(surface.fine().size(), without.fine().size()) << "its name is free";
}

TEST(Surface, WhatIsForgottenMakesRoomForImages) {
  SurfaceSettings bounded = settings();
  bounded.kept_memory = 0.2;  // of some keyframes
  Surface surface(camera_head(), bounded);
  surface.fuse(0, frame_of(room(), poses()[0]), poses()[0]);
  for (int i = 1; i < 40; ++i) {
    surface.fuse(i, frame_of(room(), poses()[1]), poses()[1]);
    surface.forget(i);
  }
  EXPECT_GT(surface.cloud({0}, 0.005).size(), 0u);
}

// Names say nothing of age: frames between keyframes count downwards.
TEST(Surface, ImagesOfWhatCameLastAreKept) {
  SurfaceSettings bounded = settings();
  bounded.kept_memory = 0.2;  // of some keyframes
  Surface surface(camera_head(), bounded);
  surface.fuse(7, frame_of(room(), poses()[0]), poses()[0]);
  for (int i = 1; i <= 40; ++i) surface.fuse(-i, frame_of(room(), poses()[0]), poses()[0]);
  EXPECT_GT(surface.cloud({-40}, 0.005).size(), 0U);
  EXPECT_GT(surface.cloud({-39}, 0.005).size(), 0U);
  EXPECT_EQ(surface.cloud({-1}, 0.005).size(), 0U);
  EXPECT_EQ(surface.cloud({7}, 0.005).size(), 0U);
  EXPECT_NO_THROW(surface.fuse(7, frame_of(room(), poses()[0]), poses()[0])) << "nothing is kept of its name";
}

TEST(Surface, ImagesOfAnEarlierMapGoFirst) {
  SurfaceSettings bounded = settings();
  bounded.kept_memory = 0.2;
  Surface surface(camera_head(), bounded);
  surface.fuse(1, frame_of(room(), poses()[0]), poses()[0]);
  const auto kept = [&](std::int64_t id) { return !surface.cloud({id}, 0.005).points.empty(); };
  surface.hand_in(1000, frame_of(room(), poses()[1]), poses()[1], Eigen::Isometry3d::Identity(), true);
  surface.refuse(0);
  ASSERT_TRUE(kept(1) && kept(1000));
  for (int i = 2; i < 40 && kept(1000); ++i) surface.fuse(i, frame_of(room(), poses()[0]), poses()[0]);
  EXPECT_FALSE(kept(1000));
  EXPECT_TRUE(kept(1));
}

TEST(Surface, FewKeyframesWait) {
  Surface surface(camera_head(), settings());
  for (int i = 0; i < 60; ++i) surface.hand_in(i, frame_of(room(), poses()[0]), poses()[0]);
  EXPECT_GT(surface.fine().size(), 100u);
  const std::size_t memory = surface.memory_bytes();
  EXPECT_EQ(surface.refuse(0), 0);
  EXPECT_LT(surface.memory_bytes() + 20 * 160 * 120 * 6, memory) << "images that waited are gone";
}

TEST(Surface, WhatMovedAwayDisappears) {
  Surface surface(camera_head(), settings());
  for (int i = 0; i < 3; ++i) surface.fuse(i, frame_of(room(), poses()[0]), poses()[0]);
  Room empty = room();
  empty.boxes.clear();
  for (int i = 3; i < 8; ++i) surface.fuse(i, frame_of(empty, poses()[0]), poses()[0]);
  for (const Eigen::Vector3f& vertex : surface.mesh().vertices) ASSERT_NEAR(vertex.z(), 1.5f, 0.01f);
}

TEST(Surface, EveryInstructionSetGivesTheSameBytes) {
  const auto fused = [] {
    Surface surface(camera_head(), settings());
    surface.fuse(0, frame_of(room(), poses()[1]), poses()[1]);
    std::vector<VoxelBlock> blocks;
    for (const VoxelBlocks::Entry& entry : surface.fine().entries()) blocks.push_back(*entry.block);
    return blocks;
  };
  const std::vector<VoxelBlock> best = fused();
  const InstructionSet former = limit_instruction_set(InstructionSet::portable);
  const std::vector<VoxelBlock> plain = fused();
  limit_instruction_set(former);
  ASSERT_EQ(best.size(), plain.size());
  EXPECT_EQ(std::memcmp(best.data(), plain.data(), best.size() * sizeof(VoxelBlock)), 0);
}

TEST(Surface, KeepsItsBounds) {
  SurfaceSettings bounded = settings();
  bounded.memory = 1;
  bounded.kept_memory = 0;
  Surface surface(camera_head(), bounded);
  surface.fuse(1, frame_of(room(), poses()[0]), poses()[0]);
  EXPECT_LE(surface.fine().size() * sizeof(VoxelBlock), 800000u);
  EXPECT_GT(surface.fine().size(), 100u);
  surface.move(1, poses()[1]);  // its images are gone: it stays where it is
  EXPECT_EQ(surface.refuse(10), 0);
}

TEST(Surface, SaysWhatGaveWay) {
  SurfaceSettings bounded = settings();
  for (const bool enough : {true, false}) {
    if (!enough) bounded.memory = 1;
    Surface surface(camera_head(), bounded);
    surface.fuse(1, frame_of(room(), poses()[0]), poses()[0]);
    EXPECT_EQ(surface.given_way() == 0, enough);
  }
}

TEST(Surface, FarSurfacesAreCoarse) {
  SurfaceSettings near_only = settings();
  near_only.fine_range = 1.2;
  Surface surface(camera_head(), near_only);
  surface.fuse(1, frame_of(room(), poses()[0]), poses()[0]);
  const Mesh mesh = surface.mesh();
  for (const VoxelBlocks::Entry& entry : surface.fine().entries())
    EXPECT_LT(surface.fine().centre(entry).z(), 1.35f);
  EXPECT_TRUE(
      std::any_of(mesh.vertices.begin(), mesh.vertices.end(), [](const auto& v) { return v.z() > 1.45f; }));
}

TEST(Surface, SaysWhatIsWrong) {
  using ::testing::HasSubstr;
  const auto message_of = [](const std::function<void()>& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Surface surface(camera_head(), settings());
  RgbdFrame frame = frame_of(room(), poses()[0]);
  surface.fuse(5, frame, poses()[0]);
  EXPECT_THAT(message_of([&] { surface.fuse(5, frame, poses()[0]); }),
              HasSubstr("keyframe 5 is there already"));
  Eigen::Isometry3d nowhere = poses()[0];
  nowhere.translation().x() = NAN;
  EXPECT_THAT(message_of([&] { surface.fuse(6, frame, nowhere); }), HasSubstr("T_map_camera must be finite"));
  frame.depth = cv::Mat(10, 10, CV_16UC1, cv::Scalar(1000));
  EXPECT_THAT(message_of([&] { surface.fuse(6, frame, poses()[0]); }), HasSubstr("10x10"));
  SurfaceSettings wrong;
  wrong.voxel_size = 0;
  EXPECT_THAT(message_of([&] { Surface(camera_head(), wrong); }), HasSubstr("voxel_size"));
  wrong = {};
  wrong.coarse_voxel_size = wrong.voxel_size;
  EXPECT_THAT(message_of([&] { Surface(camera_head(), wrong); }), HasSubstr("at least twice voxel_size"));
}

}  // namespace
}  // namespace lcmslam
