// Registration to a target of which one part is settled and another young.

#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>

namespace lcmslam {
namespace {

/// A wall ahead (x = 2) and a wall to the left (y = 1), each point by chance.
Cloud corner() {
  Random random(5);
  Cloud cloud;
  for (int i = 0; i < 800; ++i) {
    const bool ahead = i % 2 == 0;
    const auto along = static_cast<float>(random.uniform()), up = static_cast<float>(random.uniform());
    cloud.points.emplace_back(ahead ? 2 : 1 + along, ahead ? along : 1, up);
    cloud.normals.emplace_back(ahead ? -1 : 0, ahead ? 0 : -1, 0);
    cloud.sigmas.push_back(0.003f);
  }
  return cloud;
}

/// The wall to the left is new.
class HalfYoung : public KdTreeTarget {
 public:
  using KdTreeTarget::KdTreeTarget;
  bool find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const override {
    const bool there = KdTreeTarget::find(point, max_distance, found);
    found.young = std::abs(found.normal.y()) > 0.5f;
    return there;
  }
  bool finds_nearest() const override { return false; }
};

RegistrationResult register_moved(const Eigen::Vector3d& moved, RegistrationSettings settings) {
  settings.selection = SelectionKind::all;
  Prior prior;
  prior.information = 1e4 * Matrix6d::Identity();
  const Cloud seen = transformed(corner(), Eigen::Isometry3d(Eigen::Translation3d(-moved)));
  return register_cloud(seen, HalfYoung(corner()), Eigen::Isometry3d::Identity(), settings, &prior);
}

TEST(SettledPairs, TellOfTheirOwnDirectionsAlone) {
  RegistrationSettings settings;
  settings.settled_lead = true;
  const auto placed = register_moved({0.02, 0.03, 0}, settings);
  ASSERT_TRUE(placed.settled);
  EXPECT_GT(placed.settled->information(0, 0), 1e5);
  EXPECT_LT(placed.settled->information(1, 1), 1e-3 * placed.settled->information(0, 0));
  EXPECT_TRUE(placed.settled->information.isApprox(placed.settled->information.transpose(), 1e-9));
  // Where they would have led: nowhere else, for they lead already.
  EXPECT_NEAR(placed.T_target_source.translation().x(), 0.02, 1e-3);
  EXPECT_LT(std::abs(placed.settled->gradient[0] / placed.settled->information(0, 0)), 1e-3);

  settings.settled_lead = false;
  EXPECT_FALSE(register_moved({0.02, 0.03, 0}, settings).settled);
}

TEST(SettledPairs, AloneLeaveTheRestToThePrior) {
  RegistrationSettings settings;
  const Eigen::Vector3d moved(0.02, 0.03, 0);
  EXPECT_TRUE(register_moved(moved, settings).T_target_source.translation().isApprox(moved, 0.05));
  settings.settled_alone = true;
  const auto placed = register_moved(moved, settings);
  EXPECT_NEAR(placed.T_target_source.translation().x(), 0.02, 1e-3);
  EXPECT_NEAR(placed.T_target_source.translation().y(), 0, 1e-3);
  EXPECT_EQ(placed.pairs, 400);
}

}  // namespace
}  // namespace lcmslam
