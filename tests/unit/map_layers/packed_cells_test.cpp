#include <lcmslam/map_layers/packed_cells.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

/// Cells with this many different values, unknown among them, in any order.
BlockLogOdds cells_with(int values, std::uint64_t seed) {
  Random random(seed);
  BlockLogOdds cells;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int any = std::min(values - 1, static_cast<int>(random.uniform(0, values)));
    const int k = static_cast<int>(i) < values ? static_cast<int>(i) : any;
    cells[i] = k == 0 ? unknown_log_odds : static_cast<LogOdds>(5 * k - 50);
  }
  return cells;
}

TEST(PackedCells, GiveBackWhatTheyWereGiven) {
  PackedCells packed;  // one after the other in the same place
  for (const int values : {1, 2, 3, 4, 5, 16, 17, 30, 16, 4, 2, 1, 17, 2}) {
    const BlockLogOdds cells = cells_with(values, static_cast<std::uint64_t>(values));
    packed.pack(cells);
    BlockLogOdds read;
    packed.unpack(read);
    EXPECT_EQ(read, cells) << values;
    PackedCells(packed).unpack(read);
    EXPECT_EQ(read, cells) << values << ", copied";
    for (std::size_t i = 0; i < cells.size(); ++i)
      ASSERT_EQ(packed.at(static_cast<int>(i)), cells[i]) << values << " at " << i;
  }
}

TEST(PackedCells, TakeNoMoreThanTheirValuesNeed) {
  PackedCells packed;
  EXPECT_TRUE(packed.uniform());
  EXPECT_EQ(packed.at(5), unknown_log_odds);
  const auto size = [&](int values) {
    packed.pack(cells_with(values, 1));
    return packed.size();
  };
  EXPECT_EQ(size(17), 512U);
  EXPECT_EQ(size(16), 16U + 256U);
  EXPECT_EQ(size(4), 4U + 128U);
  EXPECT_EQ(size(2), 2U + 64U);
  EXPECT_EQ(size(1), 0U);
  EXPECT_TRUE(packed.uniform());
  packed.fill(7);
  EXPECT_EQ(packed.value(), 7);
}

}  // namespace
}  // namespace lcmslam
