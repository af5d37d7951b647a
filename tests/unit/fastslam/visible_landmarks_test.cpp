// Which landmarks should be in the image.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/visible_landmarks.hpp>
#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

using Scene = AssociationScene;

// The cells of the grid and the view's planes leave nothing out.
TEST(VisibleLandmarks, AreThoseInTheImage) {
  std::size_t total = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene(seed);
    const double margin = scene.settings.visibility_margin * scene.frame.width;
    std::vector<int> expected, found;
    const Eigen::Isometry3d T_camera_world = (scene.T_world_robot * scene.frame.T_robot_camera).inverse();
    for (int slot = 0; slot < scene.index.slots(); ++slot) {
      const Eigen::Vector3d p = T_camera_world * scene.map.find(static_cast<std::size_t>(slot))->mean;
      if (p.z() < 0.5 * scene.settings.minimum_range || p.norm() > 1.1 * scene.settings.maximum_range)
        continue;
      const double x = scene.frame.fx * p.x() / p.z() + scene.frame.cx;
      const double y = scene.frame.fy * p.y() / p.z() + scene.frame.cy;
      const bool inside =
          x >= -margin && x <= scene.frame.width + margin && y >= -margin && y <= scene.frame.height + margin;
      if (inside) expected.push_back(slot);
    }
    for (const VisibleLandmark& v :
         visible_landmarks(scene.map, scene.index, scene.T_world_robot, scene.frame, scene.settings))
      found.push_back(v.slot);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    total += found.size();
  }
  EXPECT_GT(total, 500u);
}

}  // namespace
}  // namespace lcmslam
