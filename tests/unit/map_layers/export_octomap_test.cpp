#include <lcmslam/map_layers/octomap/export_octomap.hpp>

#include <gtest/gtest.h>
#include <octomap/octomap.h>
#include <fstream>
#include <sstream>

#include "tests/support/filled_occupancy.hpp"

namespace lcmslam {
namespace {

TEST(ExportOctoMap, IsReadBackCellByCell) {
  OccupancyGrid grid({});
  fill(grid, {Eigen::Vector3f(-0.7f, -0.5f, -0.3f), Eigen::Vector3f(1, 0.6f, 0.9f)}, -20);
  fill(grid, {Eigen::Vector3f(0.2f, -0.1f, 0), Eigen::Vector3f(0.5f, 0.3f, 0.4f)}, 20);
  const auto file = std::filesystem::path(testing::TempDir()) / "export_octomap.bt";
  save_octomap(file, grid);
  octomap::OcTree tree(file.string());
  EXPECT_DOUBLE_EQ(tree.getResolution(), grid.settings().cell_size);
  int counts[3] = {};
  for (int x = -30; x < 40; ++x)
    for (int y = -20; y < 25; ++y)
      for (int z = -15; z < 30; ++z) {
        const Eigen::Vector3f p = grid.centre_of({x, y, z});
        const auto* node =
            tree.search(static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z()));
        const CellState there = node == nullptr             ? CellState::unknown
                                : tree.isNodeOccupied(node) ? CellState::occupied
                                                            : CellState::free;
        ASSERT_EQ(there, grid.state(p)) << p.transpose();
        ++counts[static_cast<int>(there)];
      }
  for (const int count : counts) EXPECT_GT(count, 500);
  std::filesystem::remove(file);
}

TEST(ExportOctoMap, WritesOctoMapsBytesWithoutItsWords) {
  OccupancyGrid grid({});
  fill(grid, {Eigen::Vector3f(0.2f, -0.1f, 0), Eigen::Vector3f(0.5f, 0.3f, 0.4f)}, 20);
  const auto file = std::filesystem::path(testing::TempDir()) / "quiet_octomap.bt";
  testing::internal::CaptureStderr();
  save_octomap(file, grid);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  std::ostringstream own, written;
  octomap::OcTree(file.string()).writeBinaryConst(own);
  written << std::ifstream(file, std::ios::binary).rdbuf();
  EXPECT_EQ(written.str(), own.str());
  std::filesystem::remove(file);
}

TEST(ExportOctoMap, RefusesWhatOctoMapCannotHold) {
  OccupancyGrid grid({});
  fill(grid, {Eigen::Vector3f(1400, 0, 0), Eigen::Vector3f(1400.1f, 0.1f, 0.1f)}, 20);
  const auto file = std::filesystem::path(testing::TempDir()) / "far.bt";
  EXPECT_THROW(save_octomap(file, grid), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace lcmslam
