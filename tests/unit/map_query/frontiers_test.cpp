#include <lcmslam/map_query/frontiers.hpp>

#include <gtest/gtest.h>

#include "tests/support/filled_occupancy.hpp"

namespace lcmslam {
namespace {

using Eigen::Vector3f;

/// A closed room of 2 m whose wall at x = 2 has a door and a window that nobody looked through.
OccupancyGrid room() {
  OccupancyGrid grid({});
  fill(grid, Eigen::AlignedBox3f(Vector3f(-0.04f, -1.04f, -0.04f), Vector3f(2.04f, 1.04f, 2.04f)), 20);
  fill(grid, Eigen::AlignedBox3f(Vector3f(0, -1, 0), Vector3f(2, 1, 2)), -20);
  fill(grid, Eigen::AlignedBox3f(Vector3f(2, -0.8f, 0), Vector3f(2.04f, -0.2f, 1.6f)), -20);
  fill(grid, Eigen::AlignedBox3f(Vector3f(2, 0.4f, 1.0f), Vector3f(2.04f, 0.6f, 1.2f)), -20);
  return grid;
}

TEST(Frontiers, AreWhereFreeSpaceMeetsUnknown) {
  const auto frontiers = find_frontiers(room());
  ASSERT_EQ(frontiers.size(), 2U);
  EXPECT_EQ(frontiers[0].cells, 15U * 40U);
  EXPECT_NEAR((frontiers[0].centroid - Eigen::Vector3d(2.02, -0.5, 0.8)).norm(), 0, 0.03);
  EXPECT_NEAR((frontiers[0].cell - frontiers[0].centroid).norm(), 0, 0.04);
  EXPECT_EQ(frontiers[1].cells, 25U);
}

TEST(Frontiers, SmallOnesAndThoseOutOfReachDoNotCount) {
  FrontierSettings settings;
  settings.min_cells = 26;
  EXPECT_EQ(find_frontiers(room(), settings).size(), 1U);
  settings.min_cells = 1;
  settings.highest = 0.9;
  const auto low = find_frontiers(room(), settings);
  ASSERT_EQ(low.size(), 1U);
  EXPECT_LT(low[0].cells, 15U * 40U);
  settings.lowest = 1;
  EXPECT_THROW(find_frontiers(room(), settings), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
