#include <lcmslam/map_layers/navigation_grid.hpp>

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include <opencv2/imgcodecs.hpp>

#include <lcmslam/map_layers/export_navigation_grid.hpp>
#include "tests/support/filled_occupancy.hpp"

namespace lcmslam {
namespace {

using Eigen::Vector3f;

Eigen::AlignedBox3f box(float x0, float y0, float z0, float x1, float y1, float z1) {
  return {Vector3f(x0, y0, z0), Vector3f(x1, y1, z1)};
}

/// Free space over a floor from x = -2 to 4, y = -2 to 2, the floor's top at z = 0.
class Ground : public testing::Test {
 protected:
  Ground() : grid_({}) {
    fill(grid_, box(-2, -2, -0.4f, 4, 2, 2), -20);
    fill(grid_, box(-2, -2, -0.04f, 4, 2, 0), 20);
    settings_.reach = 4;
  }
  NavigationGrid made() const { return make_navigation_grid(grid_, settings_, planar_pose(0.02, 0.02, 0)); }

  OccupancyGrid grid_;
  NavigationSettings settings_;
};

TEST_F(Ground, IsFreeWhereItIsLevelAndUnknownWhereNobodyLooked) {
  const NavigationGrid map = made();
  EXPECT_EQ(map.at(0, 0), NavigationGrid::free);
  EXPECT_EQ(map.at(3.9, 1.9), NavigationGrid::free);
  EXPECT_EQ(map.at(-1.9, -1.9), NavigationGrid::free);
  EXPECT_EQ(map.at(-2.1, 0), NavigationGrid::unknown);
  EXPECT_EQ(map.at(0, 2.1), NavigationGrid::unknown);
  EXPECT_EQ(map.at(100, 0), NavigationGrid::unknown);
  EXPECT_NEAR(map.ground(map.ground.rows / 2, map.ground.cols / 2), 0, 1e-6);
}

// A file of a hall is not cut off some metres beside where the robot stopped.
TEST_F(Ground, ReachesAllOfTheMapWhereThatIsAsked) {
  fill(grid_, box(4, -1, -0.4f, 13, 1, 2), -20);
  fill(grid_, box(4, -1, -0.04f, 13, 1, 0), 20);
  EXPECT_EQ(made().at(12.5, 0), NavigationGrid::unknown);
  settings_ = reaching_all(grid_, settings_, planar_pose(0.02, 0.02, 0));
  EXPECT_EQ(made().at(12.5, 0), NavigationGrid::free);
  EXPECT_LT(settings_.reach, 14);
  EXPECT_GE(reaching_all(grid_, NavigationSettings{}, planar_pose(5, 0, 0)).reach,
            NavigationSettings{}.reach);
}

TEST_F(Ground, WhatHangsLowerThanTheRobotIsInTheWay) {
  fill(grid_, box(1, -1, 1.2f, 1.4f, -0.6f, 1.28f), 20);
  fill(grid_, box(1, 0.6f, 1.6f, 1.4f, 1, 1.68f), 20);
  const NavigationGrid map = made();
  EXPECT_EQ(map.at(1.2, -0.8), NavigationGrid::occupied);
  EXPECT_EQ(map.at(1.2, 0.8), NavigationGrid::free);
  settings_.robot_height = 1.1;
  EXPECT_EQ(made().at(1.2, -0.8), NavigationGrid::free);
}

TEST_F(Ground, SillsAreClimbedUpToAStep) {
  settings_.max_gap = 0;                           // no way round
  fill(grid_, box(1, -2, 0, 1.2f, 2, 0.08f), 20);  // two cells high, from wall to wall
  EXPECT_EQ(made().at(1.02, 0), NavigationGrid::occupied);
  EXPECT_EQ(made().at(2, 0), NavigationGrid::unknown);  // nobody gets there
  settings_.max_step = 0.08;
  EXPECT_EQ(made().at(1.1, 0), NavigationGrid::free);
  EXPECT_EQ(made().at(2, 0), NavigationGrid::free);
}

TEST_F(Ground, RampsAreFreeUpToASlope) {
  for (int i = 0; i < 60; ++i) {  // one cell up every fifth: 0.2, 11 degrees
    const int steps = i / 5;
    const float x = 1 + 0.04f * static_cast<float>(i);
    fill(grid_, box(x, -1, -0.04f, x + 0.04f, 1, 0.04f * static_cast<float>(steps) + 0.001f), 20);
  }
  settings_.max_slope = 0.25;
  EXPECT_EQ(made().at(3, 0), NavigationGrid::free);
  EXPECT_NEAR(made().ground(100, 175), 0.4, 0.05);
  settings_.max_slope = 0.01;
  EXPECT_EQ(made().at(2, 0), NavigationGrid::occupied);
}

TEST_F(Ground, WhereItIsSeenToGoDownNobodyDrives) {
  fill(grid_, box(2, -2, -0.04f, 4, 2, 0), -20);
  EXPECT_EQ(made().at(2.02, 0), NavigationGrid::occupied);
  EXPECT_EQ(made().at(1.9, 0), NavigationGrid::free);
}

TEST_F(Ground, IsFollowedOverGapsThatNobodySaw) {
  fill(grid_, box(0.5f, -2, -0.4f, 1.5f, 2, 2), unknown_log_odds);
  EXPECT_EQ(made().at(1, 0), NavigationGrid::unknown);
  EXPECT_EQ(made().at(2, 0), NavigationGrid::free);
  settings_.max_gap = 0.5;
  EXPECT_EQ(made().at(2, 0), NavigationGrid::unknown);
}

// A door has closed behind the robot: what lies behind it is in the map all the same, and where it drove in
// the dark, too.
TEST_F(Ground, IsFollowedFromAllPlacesWhereTheRobotStood) {
  settings_.max_gap = 0;
  fill(grid_, box(1, -2, 0, 1.2f, 2, 2), 20);
  const auto from = [&](const std::vector<Eigen::Vector3d>& also_stood) {
    return make_navigation_grid(grid_, settings_, planar_pose(0.02, 0.02, 0), also_stood);
  };
  EXPECT_EQ(from({}).at(3, 0), NavigationGrid::unknown);
  const NavigationGrid map = from({{2, 0, 0}, {-3, 0, 0}, {1000, 0, 0}});
  EXPECT_EQ(map.at(3, 0), NavigationGrid::free);
  EXPECT_EQ(map.at(1.02, 0), NavigationGrid::occupied);
  EXPECT_EQ(map.at(-3.2, 0), NavigationGrid::free);
  EXPECT_EQ(map.at(-3.5, 0), NavigationGrid::unknown);
}

TEST_F(Ground, IsReadBackAsMapServerReadsIt) {
  fill(grid_, box(1, 1, 0, 1.4f, 1.4f, 1), 20);
  const NavigationGrid map = made();
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "navigation_grid";
  std::filesystem::create_directories(folder);
  save_navigation_grid(HeldFolder(folder), "kitchen", map);
  const YAML::Node yaml = YAML::LoadFile(folder / "kitchen.yaml");
  const cv::Mat image = cv::imread(folder / yaml["image"].as<std::string>(), cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(image.size(), map.cells.size());
  const double resolution = yaml["resolution"].as<double>();
  const auto origin = yaml["origin"].as<std::vector<double>>();
  // map_server: a pixel's lower left corner is at origin + resolution * (column, rows - 1 - row).
  const auto cell = [&](double x, double y) {
    const int column = static_cast<int>((x - origin[0]) / resolution);
    const int row = image.rows - 1 - static_cast<int>((y - origin[1]) / resolution);
    const double probability = (255 - image.at<std::uint8_t>(row, column)) / 255.0;
    if (probability > yaml["occupied_thresh"].as<double>()) return NavigationGrid::occupied;
    return probability < yaml["free_thresh"].as<double>() ? NavigationGrid::free : NavigationGrid::unknown;
  };
  for (double x = -2.5; x < 4; x += 0.31)
    for (double y = -2.5; y < 2.5; y += 0.23) ASSERT_EQ(cell(x, y), map.at(x, y)) << x << " " << y;
  EXPECT_EQ(cell(1.2, 1.2), NavigationGrid::occupied);
  EXPECT_THROW(save_navigation_grid(HeldFolder(folder), "../kitchen", map), std::runtime_error);
  std::filesystem::remove_all(folder);
}

TEST_F(Ground, WrongSettingsAreNamed) {
  settings_.robot_height = -1;
  EXPECT_THAT([&] { made(); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("navigation: robot_height")));
}

}  // namespace
}  // namespace lcmslam
