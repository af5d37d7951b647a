#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/planes/objects.hpp>

namespace lcmslam {
namespace {

/// A table top of 1 m x 1 m at height 0.7.
PlanePatch table() {
  PlanePatch patch;
  patch.fit.plane = {Eigen::Vector3d::UnitZ(), -0.7};
  patch.fit.centre = {0.5, 0.5, 0.7};
  patch.outline = {{0, 0, 0.7}, {1, 0, 0.7}, {1, 1, 0.7}, {0, 1, 0.7}};
  return patch;
}

/// Points on top and sides of a box that stands at a place with a heading.
void add_box(std::vector<Eigen::Vector3f>& points, const Eigen::Vector3d& place, double heading,
             const Eigen::Vector3d& size) {
  Random random(points.size() + 1);
  const Eigen::Isometry3d T = Eigen::Translation3d(place) *
                              Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                              Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3000; ++i) {
    Eigen::Vector3d p(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform());
    const int face = i % 3;
    if (face == 0) p.z() = 1;
    if (face == 1) p.x() = i % 2 - 0.5;
    if (face == 2) p.y() = i % 2 - 0.5;
    points.emplace_back((T * p.cwiseProduct(size)).cast<float>());
  }
}

TEST(Objects, StandInBoxesOfTheirPlaceSizeAndHeading) {
  std::vector<Eigen::Vector3f> points;
  add_box(points, {0.3, 0.4, 0.7}, 0.4, {0.2, 0.1, 0.25});
  add_box(points, {0.7, 0.7, 0.7}, 0, {0.08, 0.06, 0.1});
  add_box(points, {1.4, 0.5, 0.7}, 0, {0.2, 0.2, 0.2});  // beside the table
  add_box(points, {0.5, 0.1, 0.3}, 0, {0.2, 0.2, 0.2});  // below it
  const std::vector<StandingObject> objects = find_objects(points, table());
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_LT((objects[0].size - Eigen::Vector3d(0.2, 0.1, 0.25)).cwiseAbs().maxCoeff(), 0.006);
  EXPECT_LT((objects[0].T_map_box.translation() - Eigen::Vector3d(0.3, 0.4, 0.825)).norm(), 0.006);
  EXPECT_NEAR(
      std::abs(objects[0].T_map_box.linear().col(0).dot(Eigen::Vector3d(std::cos(0.4), std::sin(0.4), 0))), 1,
      2e-3);
  EXPECT_LT((objects[1].T_map_box.translation() - Eigen::Vector3d(0.7, 0.7, 0.75)).norm(), 0.006);
}

TEST(Objects, BoxesLieAlongTheirObjectsHoweverTheseAreTurned) {
  for (const double heading : {-1.3, -0.6, 0.2, 0.9, 1.5}) {
    std::vector<Eigen::Vector3f> points;
    add_box(points, {0.5, 0.5, 0.7}, heading, {0.2, 0.1, 0.25});
    const std::vector<StandingObject> objects = find_objects(points, table());
    ASSERT_EQ(objects.size(), 1u);
    const Eigen::Vector3d along(std::cos(heading), std::sin(heading), 0);
    EXPECT_NEAR(std::abs(objects[0].T_map_box.linear().col(0).dot(along)), 1, 2e-3) << heading;
    EXPECT_LT((objects[0].size - Eigen::Vector3d(0.2, 0.1, 0.25)).cwiseAbs().maxCoeff(), 0.006);
  }
}

TEST(Objects, AFewPointsAreNoObject) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 39; ++i) points.emplace_back(0.5f, 0.5f, 0.75f);
  EXPECT_TRUE(find_objects(points, table()).empty());
  points.emplace_back(0.5f, 0.5f, 0.75f);
  EXPECT_EQ(find_objects(points, table()).size(), 1u);
}

}  // namespace
}  // namespace lcmslam
