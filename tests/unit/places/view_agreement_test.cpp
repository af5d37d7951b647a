#include <lcmslam/places/view_agreement.hpp>

#include <gtest/gtest.h>

namespace lcmslam {
namespace {

FeatureFrame camera() {
  FeatureFrame frame;
  frame.width = 640;
  frame.height = 480;
  frame.fx = frame.fy = 525;
  frame.cx = 319.5;
  frame.cy = 239.5;
  return frame;
}

/// A wall across the image between two columns, z m away.
Cloud wall(float z, int from = 0, int to = 640) {
  const FeatureFrame c = camera();
  Cloud cloud;
  for (int v = 2; v < c.height; v += 4)
    for (int u = from + 2; u < to; u += 4)
      cloud.points.emplace_back(z * Eigen::Vector3d((u - c.cx) / c.fx, (v - c.cy) / c.fy, 1).cast<float>());
  return cloud;
}

TEST(ViewAgreement, SurfacesWithinTheToleranceAgree) {
  const ViewAgreement same = compare_views(wall(2), wall(2.15F), camera());
  EXPECT_EQ(same.compared, 48 * 36);
  EXPECT_EQ(same.agrees, 1);
  EXPECT_EQ(same.seen_through, 0);
}

TEST(ViewAgreement, WhatIsNearerInTheMapIsSeenThrough) {
  Cloud map = wall(2);
  const Cloud box = wall(1, 160, 480);  // before half of the wall
  map.points.insert(map.points.end(), box.points.begin(), box.points.end());
  const ViewAgreement through = compare_views(map, wall(2), camera());
  EXPECT_NEAR(through.seen_through, 0.5, 0.03);
  EXPECT_NEAR(through.agrees, 0.5, 0.03);
}

TEST(ViewAgreement, WhatHidesTheMapIsNotSeenThrough) {
  const ViewAgreement hidden = compare_views(wall(2), wall(1), camera());
  EXPECT_EQ(hidden.seen_through, 0);
  EXPECT_EQ(hidden.agrees, 0);
}

TEST(ViewAgreement, ComparesWhereBothHaveSomething) {
  const ViewAgreement half = compare_views(wall(1, 0, 320), wall(2, 160, 640), camera());
  EXPECT_EQ(half.compared, 12 * 36);
  EXPECT_EQ(half.seen_through, 1);
  EXPECT_EQ(compare_views(wall(1), {}, camera()).compared, 0);
}

TEST(ViewAgreement, LeavesOutWhatNoCameraSees) {
  Cloud odd;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  odd.points = {{nan, 0, 1}, {0, 0, -1}, {0, 0, 0}, {100, 0, 1}, {0, -100, 1}};
  EXPECT_EQ(compare_views(odd, wall(2), camera()).compared, 0);
  FeatureFrame none = camera();
  none.width = 0;
  EXPECT_EQ(compare_views(wall(1), wall(2), none).compared, 0);
}

}  // namespace
}  // namespace lcmslam
