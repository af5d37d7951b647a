#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

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

/// A star with steps of 2 cm for sides, as grids outline what was seen.
PlanePatch ragged_floor() {
  PlanePatch patch = table();
  patch.outline.clear();
  for (int i = 0; i < 1500; ++i) {
    const double angle = 2 * M_PI * i / 1500, radius = 2 + 0.8 * std::sin(7 * angle);
    const auto on_grid = [](double x) { return 0.02 * std::round(x / 0.02); };
    const Eigen::Vector3d corner(on_grid(radius * std::cos(angle)), on_grid(radius * std::sin(angle)), 0.7);
    if (!patch.outline.empty()) patch.outline.emplace_back(patch.outline.back().x(), corner.y(), 0.7);
    patch.outline.push_back(corner);
  }
  return patch;
}

TEST(Objects, StandOnWhatARaggedOutlineEncloses) {
  for (const PlanePatch& patch : {ragged_floor(), table()}) {
    std::vector<cv::Point2f> outline;
    for (const Eigen::Vector3d& corner : patch.outline)
      outline.emplace_back(static_cast<float>(corner.x()), static_cast<float>(corner.y()));
    Random random(3);
    std::vector<Eigen::Vector3f> points;
    int within = 0;
    for (int i = 0; i < 20'000; ++i) {
      const auto x = static_cast<float>(random.uniform(-3, 3)), y = static_cast<float>(random.uniform(-3, 3));
      points.emplace_back(x, y, 0.8f);
      within += cv::pointPolygonTest(outline, {x, y}, false) >= 0 ? 1 : 0;
    }
    ObjectSettings settings;
    settings.min_points = 1;
    int on_it = 0;
    for (const StandingObject& object : find_objects(points, patch, settings)) on_it += object.points;
    EXPECT_NEAR(on_it, within, 2) << "of rounding";
    EXPECT_GT(within, 400);
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
