#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/cloud/voxel_average.hpp>
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

struct Cell {
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero(),
                  colour = Eigen::Vector3d::Zero();
  double count = 0;
};

/// The plain way: one ordered map from cell coordinates (z, y, x) to sums.
std::map<std::array<long, 3>, Cell> reference(const std::vector<ColouredCloud>& clouds,
                                              const std::vector<Eigen::Isometry3d>& poses,
                                              double resolution) {
  std::map<std::array<long, 3>, Cell> cells;
  for (std::size_t k = 0; k < clouds.size(); ++k)
    for (std::size_t i = 0; i < clouds[k].size(); ++i) {
      const Eigen::Vector3d point = poses[k] * clouds[k].points[i].cast<double>();
      const auto cell = [&](int axis) { return static_cast<long>(std::floor(point[axis] / resolution)); };
      Cell& sum = cells[{cell(2), cell(1), cell(0)}];
      sum.position += point;
      sum.normal += poses[k].linear() * clouds[k].normals[i].cast<double>();
      for (int channel = 0; channel < 3; ++channel) sum.colour[channel] += clouds[k].colours[i][channel];
      ++sum.count;
    }
  return cells;
}

ColouredCloud average_voxels(const ColouredCloud& cloud, double resolution) {
  VoxelAverage average(resolution);
  average.add(cloud);
  return average.result();
}

TEST(VoxelAverage, AgreesWithAPlainReference) {
  for (const double resolution : {0.05, 0.3, 1.7}) {
    Random random(17);
    std::vector<ColouredCloud> clouds;
    std::vector<Eigen::Isometry3d> poses;
    VoxelAverage average(resolution);
    for (std::uint64_t seed = 0; seed < 9; ++seed) {  // of different sizes: runs merge in many ways
      clouds.push_back(random_cloud(seed, 200 * (1 + seed * 7 % 5), true));
      poses.push_back(random_pose(random));
      average.add(clouds.back(), poses.back());
    }
    const ColouredCloud merged = average.result();
    const auto expected = reference(clouds, poses, resolution);
    ASSERT_EQ(merged.size(), expected.size());
    ASSERT_EQ(merged.normals.size(), merged.size());
    std::size_t i = 0;
    for (const auto& [key, cell] : expected) {  // both sorted by z, y, x
      EXPECT_LT((merged.points[i].cast<double>() - cell.position / cell.count).norm(), 1e-6);
      EXPECT_LT((merged.normals[i].cast<double>() - cell.normal.normalized()).norm(), 1e-5);
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(merged.colours[i][channel], cell.colour[channel] / cell.count, 0.5 + 1e-9);
      ++i;
    }
  }
}

TEST(VoxelAverage, IsTheSameEveryTime) {
  const auto build = [] {
    VoxelAverage average(0.2);
    Random random(5);
    for (std::uint64_t seed = 0; seed < 6; ++seed)
      average.add(random_cloud(seed, 500, false), random_pose(random));
    return average.result();
  };
  const ColouredCloud first = build(), second = build();
  EXPECT_EQ(first.points, second.points);
  EXPECT_EQ(first.colours, second.colours);
  EXPECT_TRUE(first.normals.empty());
}

TEST(VoxelAverage, ThinningTwiceChangesNothing) {
  const ColouredCloud once = average_voxels(random_cloud(1, 2000, true), 0.25);
  const ColouredCloud twice = average_voxels(once, 0.25);
  EXPECT_EQ(once.points, twice.points);
  EXPECT_EQ(once.colours, twice.colours);
}

TEST(VoxelAverage, PointsWithoutACellAreLeftOut) {
  ColouredCloud cloud = random_cloud(1, 5, false);
  cloud.points[0].x() = std::nanf("");
  cloud.points[1].y() = INFINITY;
  cloud.points[2].z() = -1e30F;
  EXPECT_EQ(average_voxels(cloud, 0.001).size(), 2u);
}

TEST(VoxelAverage, OppositeAndUnknownNormalsGiveNone) {
  ColouredCloud cloud;
  cloud.points.assign(3, Eigen::Vector3f(0.5F, 0.5F, 0.5F));
  cloud.colours.assign(3, cv::Vec3b(1, 2, 3));
  cloud.normals = {Eigen::Vector3f::UnitX(), -Eigen::Vector3f::UnitX(), Eigen::Vector3f::Constant(NAN)};
  EXPECT_FALSE(average_voxels(cloud, 1).normals.at(0).allFinite());
  cloud.normals[1] = Eigen::Vector3f::UnitX();
  EXPECT_TRUE(average_voxels(cloud, 1).normals.at(0).isApprox(Eigen::Vector3f::UnitX()));
}

TEST(VoxelAverage, ImpossibleResolutionsAreRefused) {
  for (const double resolution : {0.0, -0.1, std::nan(""), HUGE_VAL})
    EXPECT_THROW(VoxelAverage{resolution}, std::invalid_argument) << resolution;
}

}  // namespace
}  // namespace lcmslam
