#include <lcmslam/dense_mapper/changed_space.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// A camera looks along z at a wall 3 m away; a plate stood before it, and is gone. Camera and world are one.
class GonePlate : public testing::Test {
 protected:
  GonePlate() {
    settings_.free_space.rotation = 1;  // each look takes every ray
    add_rectangle(wall_, {-1.5, -1.5, 3}, {0, 3, 0}, {3, 0, 0}, 0.03);
    add_rectangle(plate_, {-0.3, -0.3, 2}, {0, 0.6, 0}, {0.6, 0, 0}, 0.03);
    for (Cloud* cloud : {&wall_, &plate_}) cloud->sigmas.assign(cloud->size(), 0.003f);
  }

  static ColouredCloud coloured(const Cloud& a, const Cloud& b) {
    ColouredCloud cloud;
    for (const Cloud* part : {&a, &b}) {
      cloud.points.insert(cloud.points.end(), part->points.begin(), part->points.end());
      cloud.normals.insert(cloud.normals.end(), part->normals.begin(), part->normals.end());
      cloud.sigmas.insert(cloud.sigmas.end(), part->sigmas.begin(), part->sigmas.end());
    }
    cloud.colours.assign(cloud.size(), {1, 2, 3});
    return cloud;
  }

  void see_plate(DeformableMap& map, KeyframeStore& keyframes, int nodes) const {
    map.insert(wall_, Eigen::Isometry3d::Identity(), 0);
    map.insert(plate_, Eigen::Isometry3d::Identity(), nodes - 1);
    for (int i = 0; i < nodes; ++i)
      keyframes.add(i, i, Eigen::Isometry3d::Identity(), coloured(wall_, plate_));
  }

  /// Points nearer than the wall.
  static std::size_t plate_points(const KeyframeStore::Keyframe& keyframe) {
    std::size_t count = 0;
    for (const Eigen::Vector3f& p : keyframe.cloud.points)
      count += (keyframe.T_world_camera * p.cast<double>()).z() < 2.5 ? 1 : 0;
    return count;
  }

  const Eigen::Isometry3d still_ = Eigen::Isometry3d::Identity();
  DenseMapperSettings settings_;
  Cloud wall_, plate_;
};

TEST_F(GonePlate, LeavesTheMapAndThenOneKeyframeAFrame) {
  DeformableMap map(settings_);
  KeyframeStore keyframes(settings_);
  ChangedSpace space(settings_);
  see_plate(map, keyframes, 3);
  const std::size_t all = map.voxels().size();
  const std::size_t wall_only = keyframes.all()[0].cloud.size() - plate_points(keyframes.all()[0]);
  space.look_through(wall_, still_, map, keyframes);
  EXPECT_EQ(map.voxels().size(), all) << "one view is not enough";
  space.look_through(wall_, still_, map, keyframes);
  EXPECT_LT(map.voxels().size(), all - 150);
  EXPECT_TRUE(space.sweeping());
  for (std::size_t cleaned = 1; cleaned <= 3; ++cleaned) {
    space.look_through(wall_, still_, map, keyframes);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(plate_points(keyframes.all()[i]) == 0, i < cleaned) << cleaned << " " << i;
  }
  space.look_through(wall_, still_, map, keyframes);
  EXPECT_FALSE(space.sweeping());
  for (const auto& keyframe : keyframes.all()) {
    EXPECT_EQ(keyframe.cloud.size(), wall_only);
    EXPECT_GT(keyframe.changed, 100U);
  }
}

TEST_F(GonePlate, TheEndDoesWhatIsLeft) {
  DeformableMap map(settings_);
  KeyframeStore keyframes(settings_);
  ChangedSpace space(settings_);
  see_plate(map, keyframes, 3);
  for (int i = 0; i < 2; ++i) space.look_through(wall_, still_, map, keyframes);
  space.finish(map.voxels(), keyframes);
  EXPECT_FALSE(space.sweeping());
  for (const auto& keyframe : keyframes.all()) EXPECT_EQ(plate_points(keyframe), 0U);
}

// Between a look and the sweep the graph may move its nodes, and nodes may go.
TEST_F(GonePlate, PlacesFollowTheirNodes) {
  DeformableMap map(settings_);
  KeyframeStore keyframes(settings_);
  ChangedSpace space(settings_);
  see_plate(map, keyframes, 3);  // the plate's surfels belong to the third node
  for (int i = 0; i < 2; ++i) space.look_through(wall_, still_, map, keyframes);
  const KeyframeGraph::Thinned thinned{{false, true, false}, {0, 0, 1}};
  keyframes.thin(thinned);
  space.renumber(thinned);
  map.renumber(thinned.index);
  const Eigen::Isometry3d aside(Eigen::Translation3d(0, 5, 0));
  const KeyframeGraph::Correction correction{Eigen::Isometry3d::Identity(), aside};
  map.deform(correction);
  keyframes.deform(correction);
  space.deform(correction);
  while (keyframes.merging()) keyframes.merge_next();
  space.finish(map.voxels(), keyframes);
  ASSERT_EQ(keyframes.all().size(), 2U);
  EXPECT_GT(plate_points(keyframes.all()[0]), 100U) << "there nothing was seen through";
  EXPECT_EQ(plate_points(keyframes.all()[1]), 0U);
}

// They would bring back what a successor has lost already.
TEST_F(GonePlate, NothingIsCleanedWhileCloudsWaitToBeMerged) {
  DeformableMap map(settings_);
  KeyframeStore keyframes(settings_);
  ChangedSpace space(settings_);
  see_plate(map, keyframes, 2);
  keyframes.thin({{false, true}, {0, 0}});
  for (int i = 0; i < 5; ++i) space.look_through(wall_, still_, map, keyframes);
  EXPECT_GT(plate_points(keyframes.all()[0]), 100U);
  keyframes.merge_next();
  space.look_through(wall_, still_, map, keyframes);
  EXPECT_EQ(plate_points(keyframes.all()[0]), 0U);
}

// A graph that is thinned again and again must not keep the sweep from its end. What a swept keyframe takes
// from one that was not is swept there.
TEST_F(GonePlate, ASweepGoesOnWhereNodesGo) {
  DeformableMap map(settings_);
  KeyframeStore keyframes(settings_);
  ChangedSpace space(settings_);
  see_plate(map, keyframes, 5);
  for (int i = 0; i < 4; ++i) space.look_through(wall_, still_, map, keyframes);
  for (std::size_t i = 0; i < 5; ++i) ASSERT_EQ(plate_points(keyframes.all()[i]) == 0, i < 2) << i;
  const auto give_up = [&](const KeyframeGraph::Thinned& thinned) {
    keyframes.thin(thinned);
    space.renumber(thinned);
    keyframes.merge_next();  // all stand at one place: into the first one
  };
  give_up({{false, false, false, false, true}, {0, 1, 2, 3, 0}});
  EXPECT_GT(plate_points(keyframes.all()[0]), 100U);
  space.look_through(wall_, still_, map, keyframes);
  EXPECT_EQ(plate_points(keyframes.all()[0]), 0U);
  give_up({{false, true, false, false}, {0, 0, 1, 2}});  // swept: its successor is clean as before
  for (const std::size_t next : {1U, 2U}) {
    EXPECT_GT(plate_points(keyframes.all()[next]), 100U);
    space.look_through(wall_, still_, map, keyframes);
    EXPECT_EQ(plate_points(keyframes.all()[next]), 0U);
  }
  space.look_through(wall_, still_, map, keyframes);
  EXPECT_FALSE(space.sweeping());
}

TEST_F(GonePlate, NothingGoesWhereItIsSwitchedOffOrTheThesisMaps) {
  for (const bool thesis : {false, true}) {
    DenseMapperSettings settings = settings_;
    settings.free_space.enabled = thesis;
    if (thesis) settings.variant = VariantKind::plain;
    DeformableMap map(settings);
    KeyframeStore keyframes(settings);
    ChangedSpace space(settings);
    see_plate(map, keyframes, 1);
    const std::size_t all = map.voxels().size();
    for (int i = 0; i < 5; ++i) space.look_through(wall_, still_, map, keyframes);
    EXPECT_EQ(map.voxels().size(), all);
    EXPECT_GT(plate_points(keyframes.all()[0]), 100U);
  }
}

}  // namespace
}  // namespace lcmslam
