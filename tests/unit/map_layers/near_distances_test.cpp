#include <lcmslam/map_layers/near_distances.hpp>

#include <gmock/gmock.h>

#include <lcmslam/geometry/random.hpp>
#include "tests/support/filled_occupancy.hpp"

namespace lcmslam {
namespace {

using Eigen::Vector3d;

constexpr double side_of_cell = 0.05, sight = 3;
const DistanceSettings small{0.5, 6};  // m, MB

/// A long corridor with posts, which a robot walks along.
class LongWay : public ::testing::Test {
 protected:
  void build_to(double x) {
    for (; built_ < x; built_ += 0.5) {
      const auto at = static_cast<float>(built_);
      const auto side = static_cast<float>(random_.uniform(0.3, 2));
      for (const float y : {side, -side})
        fill(grid_, {Eigen::Vector3f(at, y, 0), Eigen::Vector3f(at + 0.1f, y + 0.1f, 2)}, 40);
    }
  }
  /// As far as the robot sees, and on.
  void drive_to(double x) {
    for (; place_.x() < x; place_.x() += 0.25) {
      build_to(place_.x() + sight);
      near_.update(grid_.take_changes());
      most_ = std::max(most_, near_.memory_bytes());
      if (auto moved = near_.moved(place_, grid_)) {
        near_ = std::move(*moved);
        ++moves_;
      }
    }
  }
  DistanceField whole() const {
    const Eigen::AlignedBox3d all(Vector3d::Constant(-1000), Vector3d::Constant(1000));
    return field_of(occupied_around(all, small.truncation, grid_), side_of_cell, small);
  }
  static Eigen::AlignedBox3d around(const Vector3d& place, double reach) {
    return {Vector3d(place - Vector3d::Constant(reach)), Vector3d(place + Vector3d::Constant(reach))};
  }

  OccupancyGrid grid_{[] {
    OccupancySettings settings;
    settings.cell_size = side_of_cell;
    return settings;
  }()};
  NearDistances near_{side_of_cell, small, sight};
  Vector3d place_{0, 0, 1};
  Random random_{4};
  double built_ = 0;
  std::size_t most_ = 0;
  int moves_ = 0;
};

TEST_F(LongWay, MemoryIsBoundedAndDistancesAroundTheRobotAreExact) {
  for (const double x : {20.0, 60.0, 100.0}) {
    drive_to(x);
    EXPECT_TRUE(near_.covers(around(place_, sight / 2)));
    const DistanceField exact = whole();
    int near_something = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vector3d point =
          place_ + Vector3d(random_.uniform(-20, 20), random_.uniform(-3, 3), random_.uniform(-1, 2));
      if (!near_.covers(around(point, 0))) continue;
      const double truth = exact.sample(point).distance;
      near_something += truth < small.truncation ? 1 : 0;
      ASSERT_EQ(near_.field().sample(point).distance, truth) << point.transpose();
    }
    EXPECT_GT(near_something, 100);
  }
  EXPECT_GT(moves_, 2);
  EXPECT_LT(most_, 1.3e6 * small.memory);  // what one step adds included
  EXPECT_FALSE(near_.covers(around({5, 0, 1}, 0.1)));
}

TEST_F(LongWay, WhatIsMadeForABoxIsExactThere) {
  drive_to(60);
  const DistanceField exact = whole();
  const Eigen::AlignedBox3d box = around({7, 0.5, 1}, 1.5);
  const DistanceField made = field_of(occupied_around(box, small.truncation, grid_), side_of_cell, small);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d point =
        box.min() + box.sizes().cwiseProduct(
                        Vector3d(random_.uniform(0, 1), random_.uniform(0, 1), random_.uniform(0, 1)));
    ASSERT_EQ(made.sample(point).distance, exact.sample(point).distance) << point.transpose();
  }
  EXPECT_LT(made.memory_bytes(), exact.memory_bytes() / 4);
}

TEST_F(LongWay, ASmallMapIsKeptWhole) {
  build_to(4);
  near_.update(grid_.take_changes());
  EXPECT_TRUE(near_.covers(around(Vector3d::Zero(), 1000)));
  EXPECT_FALSE(near_.moved({500, 0, 0}, grid_));
}

}  // namespace
}  // namespace lcmslam
