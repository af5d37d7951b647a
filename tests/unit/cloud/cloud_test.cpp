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

TEST(Clouds, ThatKnowUnlikeThingsAreNotJoined) {
  ColouredCloud plain, weighed;
  plain.points = weighed.points = {{1, 0, 0}};
  plain.colours = weighed.colours = {{1, 2, 3}};
  weighed.sigmas = {0.01f};
  ColouredCloud with_normals = plain;
  with_normals.normals = {{0, 0, 1}};
  for (const ColouredCloud* a : {&plain, &weighed, &with_normals})
    for (const ColouredCloud* b : {&plain, &weighed, &with_normals}) {
      ColouredCloud joined = *b;
      if (a != b) {
        EXPECT_THROW(append(*a, joined), std::invalid_argument);
        EXPECT_EQ(joined.size(), 1u) << "it stays as it was";
      } else {
        append(*a, joined);
        EXPECT_EQ(joined.size(), 2u);
        EXPECT_EQ(joined.sigmas.size(), 2 * a->sigmas.size());
      }
    }
  ColouredCloud empty;
  append(weighed, empty);
  append({}, empty);
  EXPECT_EQ(empty.sigmas.size(), 1u);
}

}  // namespace
}  // namespace lcmslam
