#include <lcmslam/rendering/view_camera.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

TEST(ViewCamera, FitsKeepThePointsInTheFrame) {
  const ViewFrame frame{50, 40, 300, 200};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    std::vector<Eigen::Vector3d> points;  // so few that none is an outlier
    for (int i = 0; i < 200; ++i) points.push_back(random_point(random, 3) + Eigen::Vector3d(10, -5, 2));
    const double angle = random.uniform(-3, 3);
    const Eigen::Vector2d heading(std::cos(angle), std::sin(angle));
    for (const ViewCamera& camera :
         {fit_top_view(points, frame), fit_perspective(points, frame, heading, 0.4, 0.9)}) {
      double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
      for (const Eigen::Vector3d& point : points) {
        const Eigen::Vector3d pixel = camera.project(point);
        ASSERT_GT(pixel.z(), 0) << "seed " << seed;
        left = std::min(left, pixel.x());
        right = std::max(right, pixel.x());
        top = std::min(top, pixel.y());
        bottom = std::max(bottom, pixel.y());
      }
      EXPECT_GT(left, 50) << "seed " << seed;
      EXPECT_LT(right, 350) << "seed " << seed;
      EXPECT_GT(top, 40) << "seed " << seed;
      EXPECT_LT(bottom, 240) << "seed " << seed;
      EXPECT_GT(std::max((right - left) / 300, (bottom - top) / 200), 0.8)
          << "fills the frame, seed " << seed;
    }
  }
}

TEST(ViewCamera, ASparseRimIsInThePictureAndWhatLiesFarAwayIsNot) {
  const ViewFrame frame{50, 40, 300, 200};
  Random random(3);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 20'000; ++i)
    points.emplace_back(random.uniform(-4, 4), random.uniform(-2, 2), random.uniform(0, 2));
  for (int i = 0; i < 30; ++i) points.emplace_back(4 + 0.04 * i, -1.9, 1);  // a wall that was hardly seen
  const std::size_t near = points.size();
  points.emplace_back(60, 0, 1);
  points.emplace_back(-50, 3, 30);
  for (const ViewCamera& camera :
       {fit_top_view(points, frame), fit_perspective(points, frame, Eigen::Vector2d::UnitY(), 0.4, 0.9)}) {
    double left = 1e9, right = -1e9;
    for (std::size_t i = 0; i < near; ++i) {
      const Eigen::Vector3d pixel = camera.project(points[i]);
      left = std::min(left, pixel.x());
      right = std::max(right, pixel.x());
    }
    EXPECT_GT(left, 50);
    EXPECT_LT(right, 350);
    EXPECT_GT(right - left, 250) << "fills the frame";
  }
}

TEST(ViewCamera, TheFloorPlanFindsATurnedRectangle) {
  for (const double angle : {0.0, 0.4, 1.2, 2.9}) {
    Random random(8);
    std::vector<Eigen::Vector3d> points;
    const Eigen::Rotation2Dd turn(angle);
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector2d p = turn * Eigen::Vector2d(random.uniform(-4, 4), random.uniform(-1.5, 1.5));
      points.emplace_back(p.x() + 1, p.y() - 2, random.uniform());
    }
    const FloorPlan plan = fit_floor_plan(points);
    EXPECT_GT(std::abs(plan.long_axis.dot(turn * Eigen::Vector2d::UnitX())), std::cos(0.04)) << angle;
    EXPECT_NEAR(plan.length, 8, 0.3);
    EXPECT_NEAR(plan.width, 3, 0.3);
    EXPECT_LT((plan.centre - Eigen::Vector2d(1, -2)).norm(), 0.1);
  }
}

}  // namespace
}  // namespace lcmslam
