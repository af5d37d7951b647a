#include <lcmslam/registration/preparation.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/registration/kd_tree_target.hpp>
#include <lcmslam/registration/registration.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

// A painted wall: grey values that vary smoothly along it.
Cloud painted_wall(double spacing = 0.03) {
  Cloud cloud = wall(spacing);
  for (const auto& p : cloud.points)
    cloud.intensities.push_back(0.5f + 0.25f * std::sin(4 * p.y()) + 0.2f * std::cos(5 * p.z()));
  return cloud;
}

TEST(Colour, GradientsAreThoseOfThePaint) {
  Cloud cloud = painted_wall();
  estimate_gradients(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f& p = cloud.points[i];
    if (std::abs(p.y()) > 1.4f || std::abs(p.z()) > 0.9f) continue;
    const Eigen::Vector3f expected(0, std::cos(4 * p.y()), -std::sin(5 * p.z()));
    EXPECT_LT((cloud.gradients[i] - expected).norm(), 0.08f) << p.transpose();
  }
  Cloud plain = wall();
  estimate_gradients(plain);
  EXPECT_FALSE(plain.gradients[0].allFinite());
}

// In front of a bare wall three directions slide; paint holds them.
TEST(Colour, FixesWhatGeometryLeavesFree) {
  RegistrationSettings settings;
  settings.colour_scale = 0.2;
  const KdTreeTarget target(prepared_target(painted_wall(), settings, Eigen::Vector3d::Zero()));
  const Eigen::Isometry3d start = se3_exp(twist(0.01, 0.05, -0.04, 0.02, 0, 0));
  for (const auto metric : {MetricKind::point_to_plane, MetricKind::plane_to_plane})
    for (const auto solver : {SolverKind::gauss_newton, SolverKind::levenberg_marquardt}) {
      settings.metric = metric;
      settings.solver = solver;
      settings.colour_scale = 0.2;
      const auto with = register_cloud(painted_wall(0.037), target, start, settings);
      EXPECT_TRUE(with.ok()) << to_string(with.stop);
      EXPECT_TRUE(with.degenerate.empty());
      EXPECT_LT(with.T_target_source.translation().norm(), 0.005);
      EXPECT_LT(rotation_angle(with.T_target_source), 0.005);
      settings.colour_scale = 0;
      const auto without = register_cloud(painted_wall(0.037), target, start, settings);
      EXPECT_EQ(without.degenerate.size(), 3U);
      EXPECT_GT(without.T_target_source.translation().norm(), 0.03);
    }
}

TEST(Preparation, GivesWhatThePartsAskFor) {
  Cloud bare(room().points);
  RegistrationSettings settings;
  settings.metric = MetricKind::point_to_point;
  EXPECT_FALSE(prepared_target(bare, settings, Eigen::Vector3d::Zero()).has_normals());
  settings.metric = MetricKind::plane_to_plane;
  settings.boundary = true;
  const Cloud target = prepared_target(bare, settings, Eigen::Vector3d::Zero());
  EXPECT_TRUE(target.has_normals());
  EXPECT_EQ(target.boundary.size(), target.size());
  EXPECT_TRUE(target.gradients.empty());  // no intensities
  EXPECT_TRUE(prepared_source(bare, settings, Eigen::Vector3d::Zero()).has_normals());
}

}  // namespace
}  // namespace lcmslam
