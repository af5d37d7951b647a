// The choice of the observations that say most.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/association.hpp>
#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

using Scene = AssociationScene;

TEST(Association, SelectionIsSpreadAndKeepsTheBestKnown) {
  Scene scene(2);
  const auto usable = usable_features(scene.frame, scene.settings);
  const auto matches = scene.match(usable);
  ASSERT_GT(matches.size(), 30u);
  scene.settings.maximum_observations = 20;
  const auto selected = select_informative(matches, scene.frame, usable, scene.map, scene.settings);
  ASSERT_EQ(selected.size(), 20u);
  std::vector<double> x;
  for (const auto& m : selected)
    x.push_back(
        scene.frame.features[static_cast<std::size_t>(usable[static_cast<std::size_t>(m.point)].feature)].x);
  EXPECT_LT(*std::min_element(x.begin(), x.end()), 200);
  EXPECT_GT(*std::max_element(x.begin(), x.end()), 440);
}

}  // namespace
}  // namespace lcmslam
