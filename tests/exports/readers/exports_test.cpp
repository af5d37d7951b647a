// What the robot's own programs read: PCL, OctoMap, and the keys that ROS's map_server asks for.

#include <gtest/gtest.h>
#include <octomap/octomap.h>
#include <yaml-cpp/yaml.h>

#include <opencv2/imgcodecs.hpp>

#include <lcmslam/map_store/map_export.hpp>
#include "tests/exports/sample_exports.hpp"
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

class Exports : public ::testing::Test {
 protected:
  Exports() { save_exports(folder_.path(), map_); }
  SampleMap map_;
  TemporaryFolder folder_;
};

TEST_F(Exports, PclReadsClouds) {
  for (const ColouredCloud& read : {load_ply(folder_ / "cloud.ply"), load_pcd(folder_ / "cloud.pcd")}) {
    EXPECT_EQ(read.points, map_.cloud.points);
    EXPECT_EQ(read.colours, map_.cloud.colours);
    EXPECT_EQ(read.normals, map_.cloud.normals);
  }
  for (const ColouredCloud& read :
       {load_ply(folder_ / "landmarks.ply"), load_pcd(folder_ / "landmarks.pcd")}) {
    ASSERT_EQ(read.size(), map_.landmarks.size());
    for (std::size_t i = 0; i < read.size(); ++i)
      EXPECT_EQ(read.points[i], map_.landmarks[i].mean.cast<float>().eval());
  }
  EXPECT_EQ(load_ply(folder_ / "mesh.ply").points, map_.mesh.vertices);
}

TEST_F(Exports, OctoMapReadsEveryCell) {
  const octomap::OcTree tree((folder_ / "occupancy.bt").string());
  EXPECT_DOUBLE_EQ(tree.getResolution(), map_.occupancy.settings().cell_size);
  int occupied = 0, free = 0;
  for (const Eigen::Vector3i& block : map_.occupancy.blocks())
    for (int i = 0; i < block_cells; ++i) {
      const Eigen::Vector3f p = map_.occupancy.centre_of(cell_at(block, i));
      const auto* node =
          tree.search(static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z()));
      const CellState state = map_.occupancy.state(p);
      ASSERT_EQ(node == nullptr, state == CellState::unknown) << p.transpose();
      if (node != nullptr) {
        ASSERT_EQ(tree.isNodeOccupied(node), state == CellState::occupied) << p.transpose();
      }
      occupied += state == CellState::occupied;
      free += state == CellState::free;
    }
  EXPECT_GT(occupied, 1000);
  EXPECT_GT(free, 1000);
}

// ROS's map_server and nav2's load_map_yaml() refuse where one of these is not there or is of another type.
TEST_F(Exports, MapServerReadsTheGround) {
  const YAML::Node yaml = YAML::LoadFile(folder_ / "ground.yaml");
  const cv::Mat image = cv::imread(folder_ / yaml["image"].as<std::string>(), cv::IMREAD_UNCHANGED);
  const auto resolution = yaml["resolution"].as<double>();
  const auto origin = yaml["origin"].as<std::vector<double>>();
  const auto occupied = yaml["occupied_thresh"].as<double>(), free = yaml["free_thresh"].as<double>();
  EXPECT_EQ(yaml["mode"].as<std::string>(), "trinary");
  EXPECT_EQ(yaml["negate"].as<int>(), 0);
  ASSERT_EQ(origin.size(), 3u);
  ASSERT_EQ(image.type(), CV_8UC1);
  ASSERT_EQ(image.size(), map_.ground.cells.size());
  int counts[3] = {};
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column) {
      const double dark = (255 - image.at<std::uint8_t>(row, column)) / 255.0;
      const double x = origin[0] + (column + 0.5) * resolution,
                   y = origin[1] + (image.rows - row - 0.5) * resolution;
      const auto cell = static_cast<std::int8_t>(dark > occupied ? 100 : dark < free ? 0 : -1);
      ASSERT_EQ(cell, map_.ground.at(x, y)) << x << " " << y;
      ++counts[cell == 0 ? 0 : cell > 0 ? 1 : 2];
    }
  for (const int count : counts) EXPECT_GT(count, 20);
}

}  // namespace
}  // namespace lcmslam
