#include <gtest/gtest.h>

#include <set>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/surface/cube_table.hpp>
#include <lcmslam/surface/surface_mesh.hpp>
#include "tests/unit/surface/fields.hpp"

namespace lcmslam {
namespace {

TEST(CubeTable, TrianglesUseTheCrossedEdgesAndNoOther) {
  for (int inside = 0; inside < 256; ++inside) {
    std::set<int> used, crossed;
    for (const auto& triangle : cube_table()[static_cast<std::size_t>(inside)])
      used.insert(triangle.begin(), triangle.end());
    for (int e = 0; e < 12; ++e) {
      const CubeEdge& edge = cube_edges()[static_cast<std::size_t>(e)];
      if ((inside >> edge.from & 1) != (inside >> edge.to & 1)) crossed.insert(e);
    }
    EXPECT_EQ(used, crossed) << inside;
  }
}

TEST(CubeTable, OneCornerInsideGivesOneTriangleThatLooksAwayFromIt) {
  for (int corner = 0; corner < 8; ++corner) {
    const CubeTriangles& triangles = cube_table()[static_cast<std::size_t>(1 << corner)];
    ASSERT_EQ(triangles.size(), 1u);
    Eigen::Vector3d middle[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const CubeEdge& edge = cube_edges()[triangles[0][k]];
      const auto place = [](int c) { return Eigen::Vector3d(c & 1, c >> 1 & 1, c >> 2); };
      middle[k] = 0.5 * (place(edge.from) + place(edge.to));
    }
    const Eigen::Vector3d out =
        Eigen::Vector3d::Constant(0.5) - Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2);
    EXPECT_GT((middle[1] - middle[0]).cross(middle[2] - middle[0]).dot(out), 0) << corner;
  }
}

// All 256 cubes beside all kinds of neighbours: no field, however wild, may leave a hole.
TEST(CubeTable, AnyFieldGivesAClosedSurface) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE(seed);
  Random random(seed);
  // Small differences, so that no cell counts as too steep; free space all around.
  VoxelBlocks blocks = testing::blocks_of(
      [&](const Eigen::Vector3f& p) {
        const bool rim = p.minCoeff() < 0.005f || p.maxCoeff() > 0.145f;
        return rim || random.uniform() < 0.5 ? 0.004f : -0.004f;
      },
      {0, 0, 0}, {1, 1, 1});
  SurfaceMesh mesh{SurfaceSettings()};
  mesh.update(blocks, VoxelBlocks(0.04, 4));
  const Mesh joined = mesh.joined();
  EXPECT_GT(joined.triangles.size(), 1000u);
  EXPECT_EQ(testing::open_edges(joined), 0);
}

}  // namespace
}  // namespace lcmslam
