#include <gtest/gtest.h>

#include <lcmslam/surface/surface_mesh.hpp>
#include "tests/unit/surface/fields.hpp"

namespace lcmslam {
namespace {

using testing::blocks_of;

constexpr float radius = 0.1f;

float ball(const Eigen::Vector3f& p) {
  return p.norm() - radius;
}

Mesh mesh_of(const VoxelBlocks& fine, const VoxelBlocks& coarse = VoxelBlocks(0.04, 4)) {
  SurfaceMesh mesh{SurfaceSettings()};
  mesh.update(fine, coarse);
  return mesh.joined();
}

TEST(SurfaceMesh, ABallIsClosedRoundAndWithoutSeams) {
  const Mesh mesh = mesh_of(blocks_of(ball, {-2, -2, -2}, {1, 1, 1}));
  ASSERT_GT(mesh.triangles.size(), 500u);
  EXPECT_EQ(testing::open_edges(mesh), 0);
  // Euler: V - E + F = 2, and a closed mesh has 3 F / 2 edges.
  EXPECT_EQ(2 * mesh.vertices.size(), mesh.triangles.size() + 4);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    EXPECT_NEAR(mesh.vertices[i].norm(), radius, 4e-4f);
    EXPECT_GT(mesh.normals[i].dot(mesh.vertices[i].normalized()), 0.995f);
  }
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    EXPECT_GE((b - a).cross(c - a).dot(a), -1e-9f);  // some are needles
  }
}

TEST(SurfaceMesh, WhatNobodySawIsNotMeshed) {
  VoxelBlocks blocks = blocks_of(ball, {-2, -2, -2}, {1, 1, 1});
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (blocks[i].at.z() >= 0)
      std::fill(std::begin(blocks[i].block->weight), std::end(blocks[i].block->weight), std::uint16_t{1});
  const Mesh mesh = mesh_of(blocks);
  ASSERT_FALSE(mesh.vertices.empty());
  for (const Eigen::Vector3f& vertex : mesh.vertices) EXPECT_LE(vertex.z(), 0.0f);
}

// Behind an outline: shade that a near look left beside free space that another saw. No wall stands between.
TEST(SurfaceMesh, FreeSpaceBesideShadeIsNoWall) {
  const auto outline = [](const Eigen::Vector3f& p) { return p.x() < 0.035f ? 0.04f : -0.03f; };
  EXPECT_TRUE(mesh_of(blocks_of(outline, {0, 0, 0}, {0, 0, 0})).triangles.empty());
}

TEST(SurfaceMesh, ColoursAreThoseOfTheVoxelsThatHaveSome) {
  VoxelBlocks blocks =
      blocks_of([](const Eigen::Vector3f& p) { return p.z() - 0.035f; }, {0, 0, 0}, {0, 0, 0});
  VoxelBlock& block = *blocks[0].block;
  for (int i = 0; i < VoxelBlock::voxels; ++i) {
    block.red[i] = 200;
    block.colour_weight[i] = i / 64 >= 4 ? 8 : 0;  // above the surface alone
  }
  const Mesh mesh = mesh_of(blocks);
  ASSERT_FALSE(mesh.colours.empty());
  for (const cv::Vec3b& colour : mesh.colours) EXPECT_EQ(colour, cv::Vec3b(0, 0, 200));
}

TEST(SurfaceMesh, StepByStepIsTheSameAsAtOnce) {
  VoxelBlocks blocks = blocks_of(ball, {-2, -2, -2}, {1, 1, 1});
  const VoxelBlocks coarse(0.04, 4);
  SurfaceMesh stepwise{SurfaceSettings()};
  stepwise.update(blocks, coarse);
  for (std::size_t i = 0; i < blocks.size(); i += 7) {  // dents
    blocks[i].changed = 2;
    for (std::int16_t& d : blocks[i].block->distance)
      d = static_cast<std::int16_t>(std::min(d + 5000, 32767));
  }
  stepwise.update(blocks, coarse);
  const auto same = [&] {
    const Mesh a = stepwise.joined(), b = mesh_of(blocks);
    return a.vertices == b.vertices && a.normals == b.normals && a.triangles == b.triangles;
  };
  EXPECT_TRUE(same());
  blocks.remove([](const VoxelBlocks::Entry& entry) { return entry.at.x() < 0; });
  for (std::size_t i = 0; i < blocks.size(); ++i) blocks[i].changed = 3;
  stepwise.update(blocks, coarse);
  EXPECT_TRUE(same());
}

TEST(SurfaceMesh, TheCoarseSurfaceStandsWhereThereIsNoFineOne) {
  const auto wall = [](const Eigen::Vector3f& p) { return p.z() - 0.13f; };
  VoxelBlocks coarse(0.04, 4);
  for (int x = 0; x < 3; ++x) {
    VoxelBlock& block = *coarse[static_cast<std::size_t>(coarse.find_or_make({x, 0, 0}, 1))].block;
    for (int i = 0; i < VoxelBlock::voxels; ++i) {
      const int layer = i / 64;
      block.weight[i] = 640;
      block.distance[i] =
          static_cast<std::int16_t>(32767 * wall({0, 0, 0.04f * static_cast<float>(layer)}) / 0.16f);
    }
  }
  const VoxelBlocks fine = blocks_of(wall, {0, 0, 1}, {3, 3, 1});  // x and y up to 0.32 m
  const Mesh mesh = mesh_of(fine, coarse);
  int near = 0, far = 0;
  for (const auto& t : mesh.triangles) {
    const float x = mesh.vertices[t[0]].x();
    EXPECT_NEAR(mesh.vertices[t[0]].z(), 0.13f, 1e-3f);
    near += x < 0.3f;
    far += x > 0.5f;
    const float size = (mesh.vertices[t[1]] - mesh.vertices[t[0]]).norm();
    EXPECT_LT(size, x < 0.25f ? 0.02f : 0.08f) << "a coarse triangle lies on the fine surface";
  }
  EXPECT_GT(near, 1000);
  EXPECT_GT(far, 50);
}

}  // namespace
}  // namespace lcmslam
