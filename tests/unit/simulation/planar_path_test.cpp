#include <lcmslam/simulation/planar_path.hpp>

#include <gmock/gmock.h>

namespace lcmslam {
namespace {

TEST(PlanarPath, StraightLineRunsFromFirstToLastPoint) {
  const PathLimits limits;
  const PlanarPath path({{1, 2}, {4, 6}}, limits);
  EXPECT_NEAR(path.length(), 5, 1e-9);
  EXPECT_NEAR((path.pose(0).translation() - Eigen::Vector3d(1, 2, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((path.pose(path.duration()).translation() - Eigen::Vector3d(4, 6, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(yaw(path.pose(5)), std::atan2(4, 3), 1e-9);
  // Trapezoidal profile: length / speed + speed / acceleration of driving, and the rests.
  const double driving = 5 / limits.speed + limits.speed / limits.acceleration;
  EXPECT_NEAR(path.duration(), driving + 2 * limits.rest, 1.0);
}

TEST(PlanarPath, RestsAtBothEnds) {
  const PlanarPath path({{0, 0}, {1, 0}, {2, 1}});
  EXPECT_EQ(path.travelled(0.9), 0);
  EXPECT_EQ(path.travelled(path.duration() - 0.9), path.length());
  EXPECT_TRUE(path.pose(-5).isApprox(path.pose(0)));
  EXPECT_TRUE(path.pose(path.duration() + 5).isApprox(path.pose(path.duration())));
}

TEST(PlanarPath, SpeedAndAccelerationAreContinuous) {
  const PlanarPath path({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}});
  const double h = 0.02;
  double last_speed = 0, last_acceleration = 0;
  for (double t = h; t < path.duration(); t += h) {
    const double speed = (path.travelled(t) - path.travelled(t - h)) / h;
    const double acceleration = (speed - last_speed) / h;
    EXPECT_GE(speed, 0);
    EXPECT_LT(std::abs(acceleration), 0.5) << "at " << t;
    EXPECT_LT(std::abs(acceleration - last_acceleration), 0.15) << "at " << t;
    last_speed = speed;
    last_acceleration = acceleration;
  }
}

TEST(PlanarPath, SlowsDownWhereItTurns) {
  const PlanarPath bend({{0, 0}, {1, 0}, {1.3, 0}, {1.3, 0.3}, {1.3, 1.3}, {1.3, 2.3}});
  double slowest = 1;
  for (double t = 3; t < bend.duration() - 3; t += 0.02)
    slowest = std::min(slowest, (bend.travelled(t + 0.02) - bend.travelled(t)) / 0.02);
  EXPECT_LT(slowest, 0.4);
  EXPECT_GT(slowest, 0.02);
}

TEST(PlanarPath, RefusesWhatIsNoPath) {
  EXPECT_THROW(PlanarPath({{0, 0}}), std::invalid_argument);
  EXPECT_THROW(PlanarPath({{0, 0}, {0, 0}, {1, 1}}), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
