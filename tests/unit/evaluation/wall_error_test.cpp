#include <lcmslam/evaluation/wall_error.hpp>

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

/// A wall at x = 2 that faces the origin, y from -2 to 2, z from 0 to 3, and one at its right that faces it.
std::vector<WallTriangle> walls() {
  const auto quad = [](const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                       const Eigen::Vector3f& n) {
    return std::vector<WallTriangle>{{{a, b, c}, n}, {{a, c, a + c - b}, n}};
  };
  auto all = quad({2, -2, 0}, {2, 2, 0}, {2, 2, 3}, {-1, 0, 0});
  const auto right = quad({-2, -2, 0}, {2, -2, 0}, {2, -2, 3}, {0, 1, 0});
  all.insert(all.end(), right.begin(), right.end());
  return all;
}

class Walls : public ::testing::Test {
 protected:
  // The wall ahead, `offset` (m) before its place with noise.
  void see(double seconds, double offset, double noise = 0.004, double from_y = -1.9, double to_y = 1.9) {
    for (int i = 0; i < 20000; ++i) {
      const double x = 2 - offset + random_.normal(0, noise);
      const double y = random_.uniform(from_y, to_y), z = random_.uniform(0.05, 2.9);
      points_.push_back({Eigen::Vector3d(x, y, z).cast<float>(), Eigen::Vector3f(-1, 0, 0),
                         static_cast<Utime>(1e6 * seconds)});
    }
  }
  WallError error(std::vector<Triangle> others = {}) const {
    return wall_error(points_, walls(), TriangleSurface(std::move(others)));
  }

  Random random_{4};
  std::vector<SeenPoint> points_;
};

TEST_F(Walls, OneVisitHasAThicknessAlone) {
  see(0, 0.01);
  see(15, 0.01);
  const WallError e = error();
  EXPECT_EQ(e.patches, 16 * 12);
  EXPECT_NEAR(e.thickness_median, 2 * 1.96 * 0.004, 0.002);
  EXPECT_EQ(e.revisited, 0);
  for (const double offset : {e.offset_median, e.offset_p95, e.offset_max}) EXPECT_TRUE(std::isnan(offset));
}

TEST_F(Walls, TheLastVisitIsComparedWithTheFirst) {
  see(0, 0.01);
  see(30, -0.05);                     // put right later
  see(60, 0.035, 0.004, -0.99, 1.9);  // three quarters of the wall; the last visit of the rest is the second
  see(61, 0.035, 0.004, -0.99, 1.9);
  const WallError e = error();
  EXPECT_EQ(e.revisited, 16 * 12);
  EXPECT_NEAR(e.offset_median, 0.025, 0.004);
  EXPECT_NEAR(e.offset_max, 0.06, 0.004);
  EXPECT_GT(e.thickness_median, 0.05);
}

TEST_F(Walls, OtherThingsAreNoWall) {
  see(0, 0);
  see(60, 0.1);  // the front of a cupboard
  const Triangle lower = {Eigen::Vector3f(1.9f, -2, 0), Eigen::Vector3f(1.9f, 2, 0),
                          Eigen::Vector3f(1.9f, 2, 3)};
  const Triangle upper = {Eigen::Vector3f(1.9f, -2, 0), Eigen::Vector3f(1.9f, 2, 3),
                          Eigen::Vector3f(1.9f, -2, 3)};
  EXPECT_GT(error().revisited, 0);
  EXPECT_EQ(error({lower, upper}).revisited, 0);
  EXPECT_LT(error({lower, upper}).thickness_p95, 0.025);
  // Points that face another way, and points beside the wall.
  points_.clear();
  see(0, 0);
  const int patches = error().patches;
  for (SeenPoint& p : points_) p.normal = {0, 0, 1};
  EXPECT_EQ(error().patches, 0);
  for (SeenPoint& p : points_) p.normal = {-1, 0, 0}, p.point.z() += 10;
  EXPECT_EQ(error().patches, 0);
  EXPECT_GT(patches, 0);
}

// The second picture is in no patch: offsets and thickness are those of the first one alone.
TEST_F(Walls, ADoubledWallOutOfReachIsCounted) {
  see(0, 0);
  see(60, 0);
  EXPECT_EQ(error().beyond, 0);
  const int revisited = error().revisited;
  see(120, 0.2);
  const WallError doubled = error();
  EXPECT_EQ(doubled.revisited, revisited);
  EXPECT_LT(doubled.offset_max, 0.005);
  EXPECT_EQ(doubled.points, 60'000U);
  EXPECT_NEAR(doubled.beyond, 1 / 3.0, 0.01);
  const Triangle lower = {Eigen::Vector3f(1.8f, -2, 0), Eigen::Vector3f(1.8f, 2, 0),
                          Eigen::Vector3f(1.8f, 2, 3)};
  const Triangle upper = {Eigen::Vector3f(1.8f, -2, 0), Eigen::Vector3f(1.8f, 2, 3),
                          Eigen::Vector3f(1.8f, -2, 3)};
  EXPECT_EQ(error({lower, upper}).beyond, 0) << "a cupboard's front stands there";
}

TEST_F(Walls, NoPoints) {
  EXPECT_TRUE(std::isnan(error().beyond));
  EXPECT_EQ(error().patches, 0);
  for (const double thickness : {error().thickness_median, error().thickness_p95})
    EXPECT_TRUE(std::isnan(thickness));
}

}  // namespace
}  // namespace lcmslam
