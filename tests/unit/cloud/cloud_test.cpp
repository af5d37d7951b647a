#include <gtest/gtest.h>

#include <stdexcept>

#include <lcmslam/cloud/cloud.hpp>

namespace lcmslam {
namespace {

TEST(VoxelFilter, AveragesAndRefusesBadSizes) {
  Cloud cloud;
  cloud.points = {{0.01f, 0, 0}, {0.03f, 0, 0}, {1, 0, 0}};
  const Cloud reduced = voxel_filtered(cloud, 0.1);
  ASSERT_EQ(reduced.size(), 2u);
  EXPECT_FLOAT_EQ(reduced.points[0].x(), 0.02f);
  EXPECT_THROW(voxel_filtered(cloud, 0), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
