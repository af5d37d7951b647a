#include <gtest/gtest.h>

#include <lcmslam/planes/plane_map.hpp>
#include "tests/unit/planes/table_room.hpp"

namespace lcmslam {
namespace {

const PlanePatch* largest(const std::vector<PlanePatch>& patches, PlaneLabel label) {
  const PlanePatch* best = nullptr;
  for (const PlanePatch& patch : patches)
    if (patch.label == label && (best == nullptr || patch.area > best->area)) best = &patch;
  return best;
}

TEST(PlaneMap, FloorTableAndWallsHaveTheirLabels) {
  const std::vector<PlanePatch> patches = testing::room_map().patches();
  const PlanePatch* floor = largest(patches, PlaneLabel::floor);
  const PlanePatch* table = largest(patches, PlaneLabel::table_top);
  const PlanePatch* wall = largest(patches, PlaneLabel::wall);
  ASSERT_TRUE(floor != nullptr && table != nullptr && wall != nullptr);
  EXPECT_NEAR(floor->fit.plane.offset, 0, 0.003);
  EXPECT_NEAR(table->fit.plane.offset, -testing::table_height, 0.003);
  EXPECT_GT(table->fit.plane.normal.z(), 0.9998);
  EXPECT_LT(wall->fit.plane.normal.x(), -0.9998);
  EXPECT_EQ(table->looks, 5);
  EXPECT_EQ(largest(patches, PlaneLabel::ceiling), nullptr);
  for (const PlanePatch& patch : patches) EXPECT_EQ(patch.label == PlaneLabel::table_top, &patch == table);
}

TEST(PlaneMap, TheTablesOutlineIsRightWithinThreeCentimetres) {
  const std::vector<PlanePatch> patches = testing::room_map().patches();
  const PlanePatch* table = largest(patches, PlaneLabel::table_top);
  ASSERT_NE(table, nullptr);
  const Eigen::AlignedBox2d truth(Eigen::Vector2d(1.2, -0.5), Eigen::Vector2d(2.0, 0.7));
  Eigen::AlignedBox2d seen;
  double twice = 0;
  for (std::size_t i = 0; i < table->outline.size(); ++i) {
    const Eigen::Vector2d a = table->outline[i].head<2>(),
                          b = table->outline[(i + 1) % table->outline.size()].head<2>();
    const double inside = std::min((a - truth.min()).minCoeff(), (truth.max() - a).minCoeff());
    EXPECT_LT(std::abs(truth.contains(a) ? inside : truth.exteriorDistance(a)), 0.03) << a.transpose();
    seen.extend(a);
    twice += a.x() * b.y() - a.y() * b.x();
  }
  EXPECT_LT((seen.min() - truth.min()).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LT((seen.max() - truth.max()).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_NEAR(twice / 2, 0.8 * 1.2, 0.05);  // counter-clockwise from above
}

TEST(PlaneMap, AFarSlantedFrontHasNoGaps) {
  // At its far end a pixel is 14 mm wide and, at 71 degrees of incidence, 43 mm long; cells are 20 mm.
  RgbdCalibration camera = testing::room_camera();
  camera.depth_noise = {0.0012, 0.0003, 0.4, 0};
  const testing_scene::Scene front{{}, {{Eigen::Vector3d(1, -0.01, 0.8), Eigen::Vector3d(3.5, 0, 2.0)}}};
  FramePlaneFinder finder(camera);
  PlaneMap map;
  Random random(3);
  for (const double x : {0.0, 0.1}) {
    const Eigen::Isometry3d T = Eigen::Translation3d(x, 1.2, 1.4) *
                                Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitZ()) * optical_axes();
    const cv::Mat depth = testing_scene::render(front, camera.colour, T, &camera.depth_noise, &random);
    map.insert(finder(depth), finder.cells(), T);
  }
  const std::vector<PlanePatch> patches = map.patches();
  ASSERT_EQ(patches.size(), 1u);
  EXPECT_EQ(patches[0].label, PlaneLabel::wall);
  EXPECT_NEAR(patches[0].area, 2.5 * 1.2, 0.1);
}

// A camera that measures all of a wall 4 mm too far, in every image: no number of pixels and looks tells
// that.
TEST(PlaneMap, ItsVarianceHoldsWhatAllPointsHaveInCommon) {
  RgbdCalibration camera = testing::room_camera();
  camera.depth_noise = {0.01, 0, 0, 0};
  const testing_scene::Scene wall{{{{1, 0, 0}, 2}}, {}};
  FramePlaneFinder finder(camera);
  PlaneMap map;
  Random random(3);
  const Eigen::Isometry3d T = Eigen::Translation3d(0, 0, 1) * optical_axes();
  for (int look = 0; look < 5; ++look) {
    cv::Mat depth = testing_scene::render(wall, camera.colour, T, &camera.depth_noise, &random);
    depth += 4;
    map.insert(finder(depth), finder.cells(), T);
  }
  const std::vector<PlanePatch> patches = map.patches();
  ASSERT_EQ(patches.size(), 1u);
  const PlaneFit& fit = patches[0].fit;
  const double error = std::abs(fit.centre.x() - 2), sigma = std::sqrt(fit.variance[2]);
  EXPECT_NEAR(error, 0.004, 0.001);
  EXPECT_LT(error, 3 * sigma);
  EXPECT_LT(sigma, 0.01) << "less than a single pixel's";
}

TEST(PlaneMap, AnOutlineIsWhatEnoughFramesHaveSeen) {
  const RgbdCalibration camera = testing::room_camera();
  const testing_scene::Scene wall{{{{1, 0, 0}, 2}}, {}};
  FramePlaneFinder finder(camera);
  PlaneMapSettings settings;
  settings.min_looks = 3;
  PlaneMap map(settings);
  const auto look = [&](double y) {
    const Eigen::Isometry3d T = Eigen::Translation3d(0, y, 1) * optical_axes();
    map.insert(finder(testing_scene::render(wall, camera.colour, T)), finder.cells(), T);
  };
  for (const double y : {0.0, 0.0, 5.0}) look(y);
  EXPECT_TRUE(map.patches().empty()) << "no part has three looks";
  look(0);
  const std::vector<PlanePatch> patches = map.patches();
  ASSERT_EQ(patches.size(), 1u);
  EXPECT_EQ(patches[0].looks, 4);
  EXPECT_NEAR(patches[0].area, 4 * 320.0 / 262 * 240 / 262, 0.1);
}

TEST(PlaneMap, TheTwoSidesOfAWallAreTwoPlanes) {
  const RgbdCalibration camera = testing::room_camera();
  const testing_scene::Scene wall{{{{1, 0, 0}, 2}}, {}};
  FramePlaneFinder finder(camera);
  PlaneMap map;
  for (const double x : {0.0, 4.0}) {
    const Eigen::Isometry3d T = testing::room_view(x, 0, x > 2 ? M_PI : 0);
    const cv::Mat depth = testing_scene::render(wall, camera.colour, T);
    map.insert(finder(depth), finder.cells(), T);
  }
  EXPECT_EQ(map.size(), 2u);
  EXPECT_TRUE(map.patches().empty()) << "one look is not enough";
}

/// The floor of a hall, seen every metre on the way along x.
PlaneMap hall_map(double length, const PlaneMapSettings& settings) {
  const RgbdCalibration camera = testing::room_camera();
  const testing_scene::Scene hall{{{{0, 0, 1}, 0}}, {}};
  FramePlaneFinder finder(camera);
  PlaneMap map(settings);
  for (double x = 0; x < length; ++x) {
    const Eigen::Isometry3d T =
        Eigen::Translation3d(x, 0, 1.4) * Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()) * optical_axes();
    map.insert(finder(testing_scene::render(hall, camera.colour, T)), finder.cells(), T);
  }
  return map;
}

TEST(PlaneMap, ALongFloorIsSeveralPlanesThatMeet) {
  PlaneMapSettings settings;
  settings.max_reach = 5;
  const std::vector<PlanePatch> patches = hall_map(30, settings).patches();
  EXPECT_GE(patches.size(), 3u);
  for (double x = 5; x < 28; x += 0.5) {
    double nearest = 1e9;
    for (const PlanePatch& patch : patches) {
      Eigen::AlignedBox3d box;
      for (const Eigen::Vector3d& corner : patch.outline) box.extend(corner);
      EXPECT_LT(box.sizes().x(), 20);
      nearest = std::min(nearest, box.exteriorDistance(Eigen::Vector3d(x, 0, 0)));
    }
    EXPECT_LT(nearest, 0.1) << x;
  }
  settings.max_reach = 100;
  EXPECT_EQ(hall_map(30, settings).patches().size(), 1u);
}

TEST(PlaneMap, WhatIsFarGivesWayWhereMemoryEnds) {
  PlaneMapSettings settings;
  settings.max_reach = 2;
  settings.memory = 1;
  const PlaneMap map = hall_map(60, settings);
  EXPECT_LT(map.memory_bytes(), 1'000'000u);
  Eigen::AlignedBox3d kept;
  for (const PlanePatch& patch : map.patches())
    for (const Eigen::Vector3d& corner : patch.outline) kept.extend(corner);
  EXPECT_GT(kept.max().x(), 59);
  EXPECT_GT(kept.min().x(), 10);
}

}  // namespace
}  // namespace lcmslam
