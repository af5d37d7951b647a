#include <lcmslam/registration/selection.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

// The ground with a small step: nearly all normals point up.
Cloud ground_with_step() {
  Cloud cloud;
  add_rectangle(cloud, {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  add_rectangle(cloud, {4, 0, 0}, {0, 4, 0}, {0, 0, 0.2});
  add_rectangle(cloud, {0, 4, 0}, {0, 0, 0.2}, {4, 0, 0});
  return cloud;
}

TEST(Selection, NormalSpaceAndStableTakeTheRareDirections) {
  const Cloud cloud = ground_with_step();
  const auto sideways = [&](SelectionKind kind) {
    RegistrationSettings settings;
    settings.selection = kind;
    settings.selected_points = 600;
    const auto selected = select_points(cloud, settings);
    EXPECT_EQ(selected.size(), 600U);
    EXPECT_TRUE(std::is_sorted(selected.begin(), selected.end()));
    EXPECT_EQ(std::adjacent_find(selected.begin(), selected.end()), selected.end());
    EXPECT_EQ(selected, select_points(cloud, settings)) << "not repeatable";
    const auto is_sideways = [&](std::size_t i) { return std::abs(cloud.normals[i].z()) < 0.5f; };
    return std::count_if(selected.begin(), selected.end(), is_sideways);
  };
  EXPECT_LT(sideways(SelectionKind::uniform), 100);
  EXPECT_LT(sideways(SelectionKind::random), 100);
  EXPECT_GE(sideways(SelectionKind::normal_space), 390);  // two of three directions
  EXPECT_GE(sideways(SelectionKind::stable), 300);
}

TEST(Selection, WithoutNormalsItIsRandom) {
  Cloud cloud = room();
  cloud.normals.clear();
  cloud.points[3].setConstant(NAN);
  RegistrationSettings settings;
  settings.selected_points = 100;
  settings.selection = SelectionKind::random;
  const auto random = select_points(cloud, settings);
  for (const auto kind : {SelectionKind::normal_space, SelectionKind::stable}) {
    settings.selection = kind;
    EXPECT_EQ(select_points(cloud, settings), random);
  }
}

}  // namespace
}  // namespace lcmslam
