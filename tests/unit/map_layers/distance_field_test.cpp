#include <lcmslam/map_layers/distance_field.hpp>

#include <gmock/gmock.h>

#include <map>
#include <set>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double cell = 0.05;

/// Obstacles, and the changes that tell of them.
class Obstacles {
 public:
  void set(const Vector3i& at, bool occupied) {
    const Vector3i block = block_of(at);
    auto& bits = blocks_.try_emplace(voxel_key(block), OccupancyChange{block, {}}).first->second;
    const int place = place_in_block(at);
    auto& word = bits.occupied[static_cast<std::size_t>(place / 64)];
    const std::uint64_t bit = std::uint64_t{1} << (place % 64);
    word = occupied ? word | bit : word & ~bit;
    changed_.insert(voxel_key(block));
  }
  std::vector<OccupancyChange> take_changes() {
    std::vector<OccupancyChange> changes;
    for (const std::uint64_t key : changed_) changes.push_back(blocks_.at(key));
    changed_.clear();
    return changes;
  }
  std::vector<Vector3i> cells() const {
    std::vector<Vector3i> all;
    for (const auto& [key, change] : blocks_)
      for (int i = 0; i < block_cells; ++i)
        if ((change.occupied[static_cast<std::size_t>(i / 64)] >> (i % 64) & 1) != 0)
          all.push_back(cell_at(change.block, i));
    return all;
  }

 private:
  std::map<std::uint64_t, OccupancyChange> blocks_;
  std::set<std::uint64_t> changed_;
};

double exact(const std::vector<Vector3i>& cells, const Vector3i& at, double truncation) {
  double nearest = truncation;
  for (const Vector3i& c : cells) nearest = std::min(nearest, cell * (c - at).cast<double>().norm());
  return nearest;
}

Vector3i random_cell(Random& random, int reach) {
  Vector3i at;
  for (int axis = 0; axis < 3; ++axis) at[axis] = static_cast<int>(std::floor(random.uniform(-reach, reach)));
  return at;
}

void expect_exact_through_changes(int reach) {
  Random random(3);
  const double truncation = reach * cell;
  DistanceField field(cell, {truncation});
  Obstacles obstacles;
  for (int step = 0; step < 6; ++step) {
    const std::vector<Vector3i> before = obstacles.cells();
    for (int i = 0; i < 25; ++i) obstacles.set(random_cell(random, 20), true);
    for (std::size_t i = 0; i < before.size(); i += 2) obstacles.set(before[i], false);
    field.update(obstacles.take_changes());
    const std::vector<Vector3i> cells = obstacles.cells();
    for (int i = 0; i < 1500; ++i) {
      const Vector3i at = random_cell(random, 36);
      const Eigen::Vector3f centre = ((at.cast<float>().array() + 0.5f) * static_cast<float>(cell)).matrix();
      // Beyond the reach nothing is told apart.
      const double truth = exact(cells, at, 1e9);
      ASSERT_NEAR(field.cell_distance(centre), truth <= truncation + 1e-9 ? truth : truncation, 1e-6)
          << "reach " << reach << ", step " << step << ", cell " << at.transpose();
    }
  }
}

TEST(DistanceField, IsExactThroughChanges) {
  expect_exact_through_changes(12);
  expect_exact_through_changes(40);  // several blocks away
}

TEST(DistanceField, OfNothingKeepsNothing) {
  DistanceField field(cell, {1});
  const std::size_t empty = field.memory_bytes();
  Obstacles obstacles;
  obstacles.set({1, 2, 3}, true);
  field.update(obstacles.take_changes());
  EXPECT_GT(field.memory_bytes(), empty + 10'000);
  obstacles.set({1, 2, 3}, false);
  field.update(obstacles.take_changes());
  EXPECT_LT(field.memory_bytes(), empty + 70'000);  // the table's, no blocks
  EXPECT_EQ(field.cell_distance({0.1f, 0.1f, 0.1f}), 1);
  EXPECT_EQ(field.sample({0.1, 0.1, 0.1}).gradient, Vector3d(0, 0, 0));
}

TEST(DistanceField, InterpolatesDistancesAndTheirGradient) {
  DistanceField field(cell, {1});
  Obstacles obstacles;
  for (int y = -30; y < 30; ++y)
    for (int z = -30; z < 30; ++z) obstacles.set({0, y, z}, true);
  field.update(obstacles.take_changes());
  for (const double x : {0.2, 0.233, 0.41}) {  // a wall whose cells' centres are at 0.025
    const auto sample = field.sample({x, 0.013, -0.02});
    EXPECT_NEAR(sample.distance, x - 0.025, 1e-6);
    EXPECT_NEAR((sample.gradient - Vector3d(1, 0, 0)).norm(), 0, 1e-5);
  }
  // In general the gradient is that of the distance (differences inside one cube of centres).
  obstacles.set({8, 3, 2}, true);
  field.update(obstacles.take_changes());
  const Vector3d at(0.31, 0.09, 0.045);
  const auto sample = field.sample(at);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d d = 1e-3 * Vector3d::Unit(axis);
    EXPECT_NEAR(sample.gradient[axis], (field.sample(at + d).distance - field.sample(at - d).distance) / 2e-3,
                1e-3);
  }
}

TEST(DistanceField, PointsThatAreNoneAreFarFromEverything) {
  const DistanceField field(cell, {1});
  EXPECT_EQ(field.cell_distance({std::nanf(""), 0, 0}), 1);
  EXPECT_EQ(field.sample({1e12, 0, 0}).distance, 1);
}

TEST(DistanceField, RefusesMoreCellsThanItsNumbersHoldAndFewerThanQuestionsNeed) {
  for (const double cell_size : {0.01, 1.1})
    EXPECT_THAT([&] { DistanceField field(cell_size, {2}); },
                testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("2 to 100 cells")))
        << cell_size;
}

}  // namespace
}  // namespace lcmslam
