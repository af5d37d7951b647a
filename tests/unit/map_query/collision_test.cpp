#include <lcmslam/map_query/collision.hpp>

#include <gmock/gmock.h>
#include <optional>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/map_query/newest_frame.hpp>
#include "tests/support/filled_occupancy.hpp"

namespace lcmslam {
namespace {

using Eigen::Vector3d;

/// Two posts beside a way along x: 2 m ahead, from y = 0.5 and from y = -0.5 outwards.
class Gate : public testing::Test {
 protected:
  Gate() : grid_({}), map_(0.04, {2}), newest_(0.04), checker_({&map_, &newest_.field()}) {
    for (const float side : {-0.7f, 0.5f})
      fill(grid_, Eigen::AlignedBox3f(Eigen::Vector3f(2, side, 0), Eigen::Vector3f(2.2f, side + 0.2f, 1.5f)),
           20);
    map_.update(grid_.take_changes());
  }

  static std::vector<Eigen::Isometry3d> way(double y, double heading) {
    std::vector<Eigen::Isometry3d> poses;
    for (int i = 0; i <= 100; ++i) poses.push_back(planar_pose(0.04 * i, y, heading));
    return poses;
  }
  // Stands on the ground, half a metre wide.
  static Box robot() { return {Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.7)), {0.3, 0.25, 0.6}}; }

  std::optional<std::size_t> first_collision(const std::vector<Eigen::Isometry3d>& T_map_robot) const {
    for (std::size_t i = 0; i < T_map_robot.size(); ++i)
      if (checker_.collides(Box{T_map_robot[i] * robot().T_map_box, robot().half_size})) return i;
    return std::nullopt;
  }

  OccupancyGrid grid_;
  DistanceField map_;
  NewestFrame newest_;
  CollisionChecker checker_;
};

TEST_F(Gate, LetsTheRobotPassWhereItFits) {
  EXPECT_EQ(first_collision(way(0, 0)), std::nullopt);
  EXPECT_EQ(first_collision(way(0.2, 0)), std::nullopt);
  // 0.3 m ahead of it: the post's face at 2 m.
  const auto hit = first_collision(way(0.3, 0));
  ASSERT_TRUE(hit);
  EXPECT_NEAR(0.04 * static_cast<double>(*hit), 1.7, 0.061);
  // Turned, it is as wide as its diagonal.
  EXPECT_NE(first_collision(way(0.15, 0.8)), std::nullopt);
}

TEST_F(Gate, WhoeverStepsInTheWayCountsAtOnce) {
  OccupancyGrid frame({});
  fill(frame, Eigen::AlignedBox3f(Eigen::Vector3f(1, -0.2f, 0.1f), Eigen::Vector3f(1.2f, 0.2f, 1.7f)), 1);
  newest_.show(frame.take_changes());
  const auto hit = first_collision(way(0, 0));
  ASSERT_TRUE(hit);
  EXPECT_NEAR(0.04 * static_cast<double>(*hit), 0.7, 0.061);
  newest_.show({});
  EXPECT_EQ(first_collision(way(0, 0)), std::nullopt);
}

TEST_F(Gate, BallsAndCapsulesCollideAsFarAsTheyReach) {
  const Vector3d between(2.1, 0, 1);
  EXPECT_NEAR(checker_.distance(between), 0.5, 0.021);  // to the centres of the posts' first cells
  EXPECT_FALSE(checker_.collides(Sphere{between, 0.43}));
  EXPECT_TRUE(checker_.collides(Sphere{between, 0.5}));
  EXPECT_FALSE(checker_.collides(Sphere{{1.6, 0.1, 1}, 0.45}));  // the box around it would, at its corner
  EXPECT_FALSE(checker_.collides(Sphere{{0, 0, 1}, 1.8}));       // more than the newest frame's field tells
  const Vector3d ahead(4, 0, 1), beside(0, 1.2, 1);
  EXPECT_FALSE(checker_.collides(Capsule{{0, 0, 1}, ahead, 0.43}));
  EXPECT_TRUE(checker_.collides(Capsule{{0, 0, 1}, ahead, 0.5}));
  EXPECT_TRUE(checker_.collides(Capsule{beside, {4, 0.3, 1}, 0.05}));  // through the post
  EXPECT_FALSE(checker_.collides(Capsule{beside, {0, -1.2, 1}, 0.4}));
}

// Against a search through all cells.
TEST_F(Gate, BoxesCollideAsTheirDistanceSays) {
  Random random(5);
  std::vector<Vector3d> centres;
  for (const Eigen::Vector3i& block : grid_.blocks())
    for (int i = 0; i < block_cells; ++i)
      if (grid_.state(cell_at(block, i)) == CellState::occupied)
        centres.emplace_back(grid_.centre_of(cell_at(block, i)).cast<double>());
  int collisions = 0, free = 0;
  for (int i = 0; i < 400; ++i) {
    Vector6d twist;
    for (int k = 0; k < 6; ++k) twist[k] = random.uniform(-1, 1);
    Box box{Eigen::Translation3d(2, 0, 0.8) * se3_exp(twist), {}};
    for (int k = 0; k < 3; ++k) box.half_size[k] = random.uniform(0.02, 0.4);
    double nearest = 1e9;
    for (const Vector3d& centre : centres) {
      const Vector3d inside = box.T_map_box.inverse() * centre;
      nearest = std::min(nearest, (inside.cwiseAbs() - box.half_size).cwiseMax(0).norm());
    }
    const bool answer = checker_.collides(box);
    if (nearest < 0.5 * 0.04) {
      EXPECT_TRUE(answer) << i << ": " << nearest;
    }
    if (nearest > 1.5 * 0.04) {
      EXPECT_FALSE(answer) << i << ": " << nearest;
    }
    (answer ? collisions : free) += 1;
  }
  EXPECT_GT(collisions, 50);
  EXPECT_GT(free, 50);
}

TEST(CollisionChecker, RefusesFieldsThatDoNotFit) {
  const DistanceField a(0.04), b(0.05);
  EXPECT_THROW(CollisionChecker({}), std::invalid_argument);
  EXPECT_THROW(CollisionChecker({&a, &b}), std::invalid_argument);
}

TEST(Collision, ABodyInTheOpenFitsHoweverLargeTheCells) {
  for (const double cell : {0.04, 0.3, 0.44, 1.0}) {
    const NewestFrame empty(cell);
    const DistanceField map(cell, {2});
    const CollisionChecker checker({&map, &empty.field()});
    EXPECT_FALSE(checker.collides(Sphere{{0.3, 0.2, 1}, 0.2})) << cell;
    EXPECT_FALSE(checker.collides(Box{Eigen::Isometry3d::Identity(), {2, 0.3, 0.6}})) << cell;
  }
}

}  // namespace
}  // namespace lcmslam
