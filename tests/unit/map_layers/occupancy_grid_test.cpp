#include <lcmslam/map_layers/occupancy_grid.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

BlockLogOdds filled(LogOdds value) {
  BlockLogOdds cells;
  cells.fill(value);
  return cells;
}

TEST(OccupancyGrid, TellsUnknownFreeAndOccupiedOnBothSidesOfTheOrigin) {
  OccupancyGrid grid({});
  BlockLogOdds cells = filled(unknown_log_odds);
  cells[static_cast<std::size_t>(place_in_block({-1, -2, -3}))] = 5;
  cells[static_cast<std::size_t>(place_in_block({-4, -2, -3}))] = 0;
  grid.store(block_of({-1, -2, -3}), cells);
  EXPECT_EQ(grid.state(Vector3i(-1, -2, -3)), CellState::occupied);
  EXPECT_EQ(grid.state(Vector3i(-4, -2, -3)), CellState::free);
  EXPECT_EQ(grid.state(Vector3i(-2, -2, -3)), CellState::unknown);
  EXPECT_EQ(grid.state(Vector3i(1, 2, 3)), CellState::unknown);
  EXPECT_EQ(grid.state(Vector3f(-0.01f, -0.05f, -0.09f)), CellState::occupied);
  EXPECT_EQ(grid.state(Vector3f(std::nanf(""), 0, 0)), CellState::unknown);
}

TEST(OccupancyGrid, CellsAndPlacesAreInverse) {
  for (const Vector3i& cell : {Vector3i(0, 0, 0), Vector3i(-1, 7, 8), Vector3i(-17, -8, -9)})
    EXPECT_EQ(cell_at(block_of(cell), place_in_block(cell)), cell);
}

TEST(OccupancyGrid, BlocksThatSayOneThingAreOneByte) {
  OccupancyGrid grid({});
  const Vector3i block(1, 2, 3);
  BlockLogOdds cells = filled(-10);
  cells[7] = 3;
  grid.store(block, cells);
  EXPECT_FALSE(grid.uniform(block));
  const std::size_t dense = grid.memory_bytes();
  cells[7] = -10;
  grid.store(block, cells);
  EXPECT_EQ(grid.uniform(block), LogOdds{-10});
  EXPECT_LE(grid.memory_bytes(), dense - block_cells / 8);
  BlockLogOdds read;
  grid.load(block, read);
  EXPECT_EQ(read, cells);
}

TEST(OccupancyGrid, TellsWhatBecameOrCeasedToBeOccupiedOnce) {
  OccupancyGrid grid({});
  BlockLogOdds cells = filled(-10);
  grid.store({0, 0, 0}, cells);
  EXPECT_TRUE(grid.take_changes().empty());  // free where nothing was known: no obstacle came or went
  cells[static_cast<std::size_t>(place_in_block({3, 2, 1}))] = 1;
  grid.store({0, 0, 0}, cells);
  cells[static_cast<std::size_t>(place_in_block({3, 2, 1}))] = 9;
  grid.store({0, 0, 0}, cells);
  const auto changes = grid.take_changes();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].occupied[1], std::uint64_t{1} << (8 * 2 + 3));
  EXPECT_TRUE(grid.take_changes().empty());
  grid.store_uniform({0, 0, 0}, -10);
  const auto gone = grid.take_changes();
  ASSERT_EQ(gone.size(), 1U);
  EXPECT_EQ(gone[0].occupied[1], 0U);
}

TEST(OccupancyGrid, TheFarthestGiveWayAndAreCounted) {
  OccupancySettings settings;
  settings.max_blocks = 100;
  OccupancyGrid grid(settings);
  BlockLogOdds cells = filled(-10);
  cells[0] = 20;
  for (int x = 0; x < 120; ++x) grid.store({x, 0, 0}, cells);
  grid.take_changes();
  const std::size_t full = grid.memory_bytes();
  grid.make_room(grid.centre_of({8 * 119, 0, 0}));
  EXPECT_EQ(grid.forgotten(), 30U);
  EXPECT_EQ(grid.blocks().size(), 90U);
  EXPECT_FALSE(grid.uniform({30, 0, 0}));
  EXPECT_EQ(grid.uniform({29, 0, 0}), unknown_log_odds);
  EXPECT_EQ(grid.take_changes().size(), 30U);
  EXPECT_LT(grid.memory_bytes(), full);
  grid.make_room(grid.centre_of({0, 0, 0}));
  EXPECT_EQ(grid.forgotten(), 30U);
}

TEST(OccupancyGrid, AdoptedGridsCountAsChangedWhereEitherHeldSomething) {
  OccupancyGrid grid({}), other({});
  BlockLogOdds cells = filled(-10);
  cells[0] = 20;
  grid.store({1, 0, 0}, cells);
  grid.take_changes();
  other.store({2, 0, 0}, cells);
  grid.adopt(std::move(other));
  const auto changes = grid.take_changes();
  ASSERT_EQ(changes.size(), 2U);
  for (const OccupancyChange& change : changes)
    EXPECT_EQ(change.occupied[0], change.block.x() == 2 ? 1U : 0U) << change.block.transpose();
}

TEST(OccupancyGrid, CopiesHoldTheSameAndAreFree) {
  OccupancyGrid grid({});
  BlockLogOdds cells = filled(-10);
  cells[0] = 20;
  grid.store({1, 0, 0}, cells);
  grid.store({2, 0, 0}, filled(-20));
  const OccupancyGrid copy = grid.copy();
  grid.store_uniform({1, 0, 0}, -10);
  BlockLogOdds read;
  copy.load({1, 0, 0}, read);
  EXPECT_EQ(read, cells);
  EXPECT_EQ(copy.uniform({2, 0, 0}), LogOdds{-20});
}

TEST(OccupancyGrid, WrongSettingsAreNamed) {
  OccupancySettings settings;
  settings.cell_size = 0;
  EXPECT_THAT([&] { OccupancyGrid grid(settings); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("occupancy: cell_size")));
}

}  // namespace
}  // namespace lcmslam
