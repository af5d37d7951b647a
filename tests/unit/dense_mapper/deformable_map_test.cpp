#include <lcmslam/dense_mapper/deformable_map.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

Cloud plate(double x) {
  Cloud cloud;
  add_rectangle(cloud, {x, -0.5, -0.5}, {0, 0, 1}, {0, 1, 0}, 0.03);
  cloud.sigmas.assign(cloud.size(), 0.003f);
  return cloud;
}

bool knows(const VoxelMap& map, const Eigen::Vector3d& p) {
  TargetPoint found;
  return map.find(p.cast<float>(), 0.05f, found);
}

const Eigen::Isometry3d aside = Eigen::Isometry3d(Eigen::Translation3d(0, 3, 0));
const Eigen::Isometry3d up = Eigen::Isometry3d(Eigen::Translation3d(0, 0, 2));

// What is read does not change meanwhile, and what comes meanwhile stands in the deformed map in the end.
TEST(DeformableMap, InsertionsWaitWhileItIsDeformed) {
  DeformableMap map({});
  map.insert(plate(1), Eigen::Isometry3d::Identity(), 0);
  map.insert(plate(2), Eigen::Isometry3d::Identity(), 1);
  const std::size_t size = map.voxels().size();
  map.begin_deforming({aside, up}, 1'000'000);
  EXPECT_TRUE(map.deforming());
  map.insert(plate(3), Eigen::Isometry3d::Identity(), 0);
  map.insert(plate(4), Eigen::Isometry3d::Identity(), 7);  // a node that came later: it goes with the last
  EXPECT_EQ(map.voxels().size(), size);
  EXPECT_TRUE(knows(map.voxels(), {1, 0, 0}));
  EXPECT_GT(map.memory_bytes(), map.voxels().memory_bytes());
  const auto& correction = map.finish_deforming();
  EXPECT_FALSE(map.deforming());
  ASSERT_EQ(correction.size(), 2U);
  EXPECT_TRUE(correction[0].isApprox(aside));
  EXPECT_EQ(map.memory_bytes(), map.voxels().memory_bytes());
  for (const auto& [x, T] : {std::pair(1.0, aside), {2.0, up}, {3.0, aside}, {4.0, up}}) {
    SCOPED_TRACE(x);
    EXPECT_FALSE(knows(map.voxels(), {x, 0, 0}));
    EXPECT_TRUE(knows(map.voxels(), T * Eigen::Vector3d(x, 0, 0)));
  }
  // The same as if it had been done at once.
  DeformableMap other({});
  other.insert(plate(1), Eigen::Isometry3d::Identity(), 0);
  other.insert(plate(2), Eigen::Isometry3d::Identity(), 1);
  other.deform({aside, up});
  other.insert(transformed(plate(3), aside), aside, 0);
  other.insert(transformed(plate(4), up), up, 7);
  EXPECT_EQ(map.voxels().cloud().points, other.voxels().cloud().points);
  EXPECT_EQ(map.voxels().revision(), other.voxels().revision());
}

// By message time, so that every machine takes it over at the same frame.
TEST(DeformableMap, IsDueAtATimeThatGrowsWithTheMap) {
  DenseMapperSettings settings;
  settings.deform_time = 0.1;
  settings.deform_time_per_surfel = 1e-4;
  DeformableMap map(settings);
  map.insert(plate(1), Eigen::Isometry3d::Identity(), 0);
  EXPECT_FALSE(map.is_due(5'000'000));
  map.begin_deforming({up}, 1'000'000);
  const Utime due = 1'100'000 + static_cast<Utime>(100 * map.voxels().size());
  EXPECT_FALSE(map.is_due(due - 2));
  EXPECT_TRUE(map.is_due(due + 2));
  map.finish_deforming();
  EXPECT_FALSE(map.is_due(due + 2));
}

/// A small map that has come far since its first keyframe.
struct Forgetful {
  DeformableMap map;
  std::vector<KeyframeStore::Keyframe> keyframes;

  Forgetful() : map(settings()) {
    ColouredCloud seen;
    const Cloud first = plate(1);
    seen.points = first.points;
    seen.normals = first.normals;
    seen.sigmas = first.sigmas;
    seen.colours.assign(seen.size(), {9, 9, 9});
    keyframes = {{0, 0, Eigen::Isometry3d::Identity(), seen, 0.02, 0}};
    map.insert(first, Eigen::Isometry3d::Identity(), 0);
    for (int i = 1; i < 8; ++i)
      map.insert(plate(1 + 3 * i), Eigen::Isometry3d(Eigen::Translation3d(3.0 * i, 0, 0)), i);
  }
  static DenseMapperSettings settings() {
    DenseMapperSettings settings;
    settings.map.max_blocks = 200;
    return settings;
  }
};

TEST(DeformableMap, KeyframesAroundGiveBackWhatWasForgotten) {
  Forgetful forgetful;
  DeformableMap& map = forgetful.map;
  const auto& keyframes = forgetful.keyframes;
  ASSERT_TRUE(map.voxels().has_forgotten());
  ASSERT_FALSE(knows(map.voxels(), {1, 0, 0}));
  map.restore(keyframes, planar_pose(4, 0, 0));
  EXPECT_FALSE(knows(map.voxels(), {1, 0, 0})) << "too far from the camera";
  map.restore(keyframes, planar_pose(2, 0, 0));
  EXPECT_TRUE(knows(map.voxels(), {1, 0, 0}));
  const std::int32_t revision = map.voxels().revision();
  map.restore(keyframes, planar_pose(2, 0, 0));
  EXPECT_EQ(map.voxels().revision(), revision) << "it is known already";
}

// A map that is being deformed cannot tell what it has got back already.
TEST(DeformableMap, NothingIsGivenBackTwice) {
  Forgetful forgetful;
  const std::vector<Eigen::Isometry3d> nothing_moves(8, Eigen::Isometry3d::Identity());
  forgetful.map.begin_deforming(nothing_moves, 0);
  const std::size_t bytes = forgetful.map.memory_bytes();
  for (int i = 0; i < 5; ++i) forgetful.map.restore(forgetful.keyframes, planar_pose(2, 0, 0));
  EXPECT_EQ(forgetful.map.memory_bytes(), bytes);
  forgetful.map.finish_deforming();
  ASSERT_FALSE(knows(forgetful.map.voxels(), {1, 0, 0}));
  forgetful.map.restore(forgetful.keyframes, planar_pose(2, 0, 0));
  EXPECT_TRUE(knows(forgetful.map.voxels(), {1, 0, 0}));
}

TEST(DeformableMap, RefusesWhatWouldTouchAMapThatIsRead) {
  DeformableMap map({});
  map.insert(plate(1), Eigen::Isometry3d::Identity(), 0);
  map.begin_deforming({up}, 0);
  EXPECT_THROW(map.begin_deforming({up}, 0), std::logic_error);
  EXPECT_THROW(map.deform({up}), std::logic_error);
  EXPECT_THROW(map.renumber({0}), std::logic_error);
  EXPECT_THROW(map.look_through(FreeSpaceView({}, {}), up, {}, 0), std::logic_error);
  map.finish_deforming();
  EXPECT_NO_THROW(map.renumber({0}));
}

}  // namespace
}  // namespace lcmslam
