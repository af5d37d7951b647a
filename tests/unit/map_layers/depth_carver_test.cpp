// What images carve, against OctoMap's rays.

#include <lcmslam/map_layers/depth_carver.hpp>

#include <gmock/gmock.h>
#include <octomap/octomap.h>

#include "tests/unit/simulation/box_room.hpp"

namespace lcmslam {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

CameraModel small_camera() {
  return pinhole_camera(160, 120, 131);
}

/// Exact depth of a scene, m.
cv::Mat depth_of(const RayCaster& caster, const CameraModel& camera,
                 const Eigen::Isometry3d& T_world_camera) {
  cv::Mat depth(camera.height, camera.width, CV_32FC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const Vector3f ray = (T_world_camera.linear() * camera.ray({u, v})).cast<float>();
      depth.at<float>(v, u) = caster.cast(T_world_camera.translation().cast<float>(), ray);
    }
  return depth;
}

/// A room with a table and a post, from several sides.
struct Views {
  Scene scene = box_room(3,
                         "boxes:\n"
                         "  - {at: [2, 0.4, 0.7], size: [0.8, 0.6, 0.06], material: wall}\n"
                         "  - {at: [1.7, -0.6, 0], size: [0.2, 0.2, 1.7], material: red}\n");
  std::vector<Eigen::Isometry3d> poses;
  std::vector<cv::Mat> depths;
  Views() {
    for (int i = 0; i < 6; ++i) {
      poses.push_back(planar_pose(0.1 * i - 0.3, 0.25 * (i - 2.5), 0.12 * (2.5 - i)) *
                      Eigen::Translation3d(0, 0, 1.3) * Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitY()) *
                      optical_axes());
      depths.push_back(depth_of(RayCaster(scene), small_camera(), poses.back()));
    }
  }
  static const Views& instance() {
    static const Views views;
    return views;
  }
};

octomap::OcTree octomap_of(const Views& views, const OccupancySettings& settings) {
  octomap::OcTree tree(settings.cell_size);
  for (std::size_t i = 0; i < views.poses.size(); ++i) {
    octomap::Pointcloud cloud;
    const CameraModel camera = small_camera();
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) {
        const float z = views.depths[i].at<float>(v, u);
        if (!(z <= settings.max_range)) continue;
        const Eigen::Vector3d p = views.poses[i] * (z * camera.ray({u, v}));
        cloud.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
      }
    const Eigen::Vector3d t = views.poses[i].translation();
    tree.insertPointCloud(cloud, octomap::point3d(static_cast<float>(t.x()), static_cast<float>(t.y()),
                                                  static_cast<float>(t.z())));
  }
  return tree;
}

TEST(DepthCarver, AgreesWithOctoMap) {
  const Views& views = Views::instance();
  OccupancySettings settings;
  settings.cell_size = 0.047;  // no wall lies between two cells
  OccupancyGrid grid(settings);
  DepthCarver carver;
  for (std::size_t i = 0; i < views.poses.size(); ++i)
    carver.carve(views.depths[i], small_camera(), views.poses[i], grid);
  octomap::OcTree tree = octomap_of(views, grid.settings());
  tree.expand();
  int occupied = 0, occupied_here = 0, free = 0, free_here = 0, free_as_occupied = 0;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    const Vector3f centre(leaf.getCoordinate().x(), leaf.getCoordinate().y(), leaf.getCoordinate().z());
    const CellState state = grid.state(centre);
    // Cells that a surface only grazes are told differently by different views.
    if (tree.isNodeOccupied(*leaf) && leaf->getLogOdds() < 1.2f) continue;
    if (tree.isNodeOccupied(*leaf)) {
      ++occupied;
      occupied_here += state == CellState::occupied ? 1 : 0;
    } else {
      ++free;
      free_here += state == CellState::free ? 1 : 0;
      free_as_occupied += state == CellState::occupied ? 1 : 0;
    }
  }
  std::cout << "occupied " << occupied_here << " of " << occupied << ", free " << free_here << " of " << free
            << ", free there and occupied here " << free_as_occupied << "\n";
  ASSERT_GT(occupied, 5000);
  EXPECT_GT(occupied_here, 0.95 * occupied);
  EXPECT_GT(free_here, 0.9 * free);
  EXPECT_LT(free_as_occupied, 0.01 * free);
}

// A cell in whose corner something thin stands while its middle is seen through.
TEST(DepthCarver, AHitWinsOverAMiss) {
  const CameraModel camera = pinhole_camera(320, 240, 262);
  OccupancyGrid grid({});
  DepthCarver carver;
  cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(3));
  depth.at<float>(120, 160) = 1.02f;
  carver.carve(depth, camera, Eigen::Isometry3d::Identity(), grid);
  depth.at<float>(120, 160) = 3;
  carver.carve(depth, camera, Eigen::Isometry3d::Identity(), grid);
  EXPECT_EQ(grid.state(Vector3i(0, 0, 25)), CellState::occupied);  // a hit and a miss: not two misses
  EXPECT_EQ(grid.state(Vector3i(0, 0, 20)), CellState::free);
}

TEST(DepthCarver, PixelsWithoutDepthTellNothing) {
  OccupancyGrid grid({});
  DepthCarver carver;
  cv::Mat depth(120, 160, CV_16UC1, cv::Scalar(2000));
  depth(cv::Rect(60, 40, 40, 40)).setTo(0);
  carver.carve(depth, small_camera(), Eigen::Isometry3d::Identity(), grid);
  EXPECT_EQ(grid.state(Vector3f(0, 0, 1)), CellState::unknown);      // before the hole
  EXPECT_EQ(grid.state(Vector3f(0, 0, 2.01f)), CellState::unknown);  // in it
  EXPECT_EQ(grid.state(Vector3f(0.5f, 0, 1)), CellState::free);
  EXPECT_EQ(grid.state(Vector3f(0.9f, 0, 2)), CellState::occupied);
  EXPECT_EQ(grid.state(Vector3f(0.9f, 0, 2.2f)), CellState::unknown);  // behind the wall
  EXPECT_EQ(grid.state(Vector3f(0, 0, -1)), CellState::unknown);       // behind the camera
}

TEST(DepthCarver, AHoleAmongPixelsThatSeeThroughIsNoObstacleAndANearPixelAmongHolesIsOne) {
  const CameraModel camera = pinhole_camera(320, 240, 262);
  OccupancyGrid grid({});
  DepthCarver carver;
  cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(3));
  for (int v = 0; v < depth.rows; ++v)
    for (int u = v % 2; u < depth.cols; u += 2) depth.at<float>(v, u) = 0;
  depth.at<float>(80, 221) = 1.5f;
  carver.carve(depth, camera, Eigen::Isometry3d::Identity(), grid);
  EXPECT_EQ(grid.state(Vector3f(0.02f, 0.02f, 2.02f)), CellState::free);
  const Vector3f thin = (1.5 * camera.ray({221, 80})).cast<float>();
  EXPECT_NE(grid.state(Vector3f(1.1f * thin)), CellState::free);
}

TEST(DepthCarver, WhatWasMarkedAsGoneIsFreeSpaceWithoutASurface) {
  OccupancyGrid grid({});
  DepthCarver carver;
  carver.carve(cv::Mat(120, 160, CV_16SC1, cv::Scalar(-2000)), small_camera(), Eigen::Isometry3d::Identity(),
               grid);
  EXPECT_EQ(grid.state(Vector3f(0, 0, 1.5f)), CellState::free);
  EXPECT_NE(grid.state(Vector3f(0, 0, 2)), CellState::occupied);
  EXPECT_TRUE(carver.hits().empty());
}

TEST(DepthCarver, BeyondTheRangeNothingIsHitButSpaceIsFreeUpToIt) {
  OccupancySettings settings;
  settings.max_range = 1.5;
  OccupancyGrid grid(settings);
  DepthCarver carver;
  carver.carve(cv::Mat(120, 160, CV_32FC1, cv::Scalar(2)), small_camera(), Eigen::Isometry3d::Identity(),
               grid);
  EXPECT_EQ(grid.state(Vector3f(0, 0, 1.4f)), CellState::free);
  EXPECT_EQ(grid.state(Vector3f(0, 0, 1.6f)), CellState::unknown);
  EXPECT_EQ(grid.state(Vector3f(0, 0, 2)), CellState::unknown);
}

TEST(DepthCarver, SeesThroughABentLens) {
  CameraModel bent = small_camera();
  bent.distortion = {-0.2, 0.05, 0, 0};
  const Eigen::Isometry3d pose = level_camera();
  const Scene scene = box_room(2.5);
  OccupancyGrid straight({}), distorted({});
  DepthCarver carver;
  carver.carve(depth_of(RayCaster(scene), small_camera(), pose), small_camera(), pose, straight);
  carver.carve(depth_of(RayCaster(scene), bent, pose), bent, pose, distorted);
  int both = 0, differ = 0;
  for (const Vector3i& block : straight.blocks())
    for (int i = 0; i < block_cells; ++i) {
      const CellState a = straight.state(cell_at(block, i)), b = distorted.state(cell_at(block, i));
      if (a == CellState::unknown || b == CellState::unknown) continue;
      ++both;
      differ += a != b ? 1 : 0;
    }
  EXPECT_GT(both, 20'000);
  EXPECT_LT(differ, 0.01 * both);
}

TEST(DepthCarver, RefusesWhatIsNoDepthImageOfTheCamera) {
  OccupancyGrid grid({});
  DepthCarver carver;
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_THAT([&] { carver.carve(cv::Mat(100, 160, CV_16UC1), small_camera(), here, grid); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("160 x 100")));
  EXPECT_THROW(carver.carve(cv::Mat(120, 160, CV_8UC1), small_camera(), here, grid), std::invalid_argument);
  Eigen::Isometry3d nowhere = here;
  nowhere.translation().x() = std::nan("");
  EXPECT_THAT(
      [&] { carver.carve(cv::Mat(120, 160, CV_16UC1, cv::Scalar(0)), small_camera(), nowhere, grid); },
      testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("T_map_camera")));
  EXPECT_TRUE(grid.blocks().empty());
}

}  // namespace
}  // namespace lcmslam
