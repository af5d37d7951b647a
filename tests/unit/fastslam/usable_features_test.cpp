// What of a frame the filter can use.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <lcmslam/fastslam/association/usable_features.hpp>
#include <lcmslam/geometry/transform.hpp>
#include "tests/unit/fastslam/association_scene.hpp"

namespace lcmslam {
namespace {

using Scene = AssociationScene;

TEST(UsableFeatures, UnusableFeaturesAreLeftOut) {
  Scene scene(1);
  scene.settings.use_bearings = false;
  const std::size_t before = usable_features(scene.frame, scene.settings).size();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scene.frame.features[0].point.x() = nan;
  scene.frame.features[1].depth_sigma = nan;
  scene.frame.features[2].kind = MeasurementKind::bearing;
  scene.frame.features[3].depth_sigma = -1;
  scene.frame.features[4].point *= 100.f;
  scene.frame.features[5].point.z() *= -1;
  scene.frame.features[6].x = std::numeric_limits<float>::infinity();
  const auto usable = usable_features(scene.frame, scene.settings);
  EXPECT_EQ(usable.size(), before - 7);
  for (const FeaturePoint& point : usable) EXPECT_GT(point.feature, 6);
  scene.frame.fx = 0;
  EXPECT_TRUE(usable_features(scene.frame, scene.settings).empty());
}

TEST(UsableFeatures, AFixedNoiseIsThatOfEveryPointAndAxis) {
  Scene scene(1);
  scene.settings.use_bearings = false;
  scene.settings.measurement_sigma = 0.03;
  scene.settings.measurement_inflation = 2;
  const auto usable = usable_features(scene.frame, scene.settings);
  ASSERT_FALSE(usable.empty());
  const Eigen::Matrix3d expected = 2 * 0.03 * 0.03 * Eigen::Matrix3d::Identity();
  for (const FeaturePoint& point : usable)
    EXPECT_TRUE(point.measurement.covariance.isApprox(expected, 1e-12)) << point.measurement.covariance;
}

TEST(UsableFeatures, PlanarMeasurementsNeedASigmaAndAnIdentity) {
  FeatureFrame frame;
  frame.width = frame.height = 1;
  frame.fx = frame.fy = 1;
  frame.pixel_sigma = 0.02f;
  Feature sound;
  sound.kind = MeasurementKind::range_bearing;
  sound.landmark_id = 3;
  sound.point = {2, 0.5f, 0};
  sound.depth_sigma = 0.1f;
  const float inf = std::numeric_limits<float>::infinity();
  for (const MeasurementKind kind : {MeasurementKind::range_bearing, MeasurementKind::planar}) {
    sound.kind = kind;
    frame.features.assign(8, sound);
    frame.features[1].depth_sigma = inf;
    frame.features[2].depth_sigma = std::numeric_limits<float>::quiet_NaN();
    frame.features[3].depth_sigma = 0;
    frame.features[4].point.x() = inf;
    frame.features[5].point.y() = std::numeric_limits<float>::quiet_NaN();
    frame.features[6].point.x() = 1e30f;
    frame.features[7].landmark_id = -1;
    const auto usable = usable_features(frame, {});
    ASSERT_EQ(usable.size(), 1u);
    EXPECT_EQ(usable[0].feature, 0);
  }
}

TEST(UsableFeatures, FeaturesWithoutDepthAreBearings) {
  Scene scene(1);
  const auto points = usable_features(scene.frame, scene.settings);
  for (std::size_t i = 0; i < scene.frame.features.size(); i += 2) {
    scene.frame.features[i].kind = MeasurementKind::bearing;
    scene.frame.features[i].point.setConstant(std::numeric_limits<float>::quiet_NaN());
    scene.frame.features[i].depth_sigma = std::numeric_limits<float>::quiet_NaN();
  }
  const auto usable = usable_features(scene.frame, scene.settings);
  EXPECT_EQ(usable.size(), points.size()) << "in range, all of them";
  int bearings = 0, right = 0;
  for (const FeaturePoint& p : usable) {
    const Feature& f = scene.frame.features[static_cast<std::size_t>(p.feature)];
    EXPECT_EQ(p.is_bearing(), f.kind == MeasurementKind::bearing);
    bearings += p.is_bearing();
    const int slot = scene.truth[static_cast<std::size_t>(p.feature)];
    if (!p.is_bearing() || slot < 0) continue;
    const LandmarkGaussian& landmark = *scene.map.find(static_cast<std::size_t>(slot));
    right += innovate(landmark, p.measurement, scene.T_world_robot).distance2 < 13.8;  // chi-square, 99.9 %
  }
  EXPECT_NEAR(bearings, static_cast<double>(usable.size()) / 2, 1);
  EXPECT_GT(right, 0.75 * bearings) << "the others show other landmarks, or none";
  const auto matches = scene.match(usable);
  const auto of_bearings = std::count_if(matches.begin(), matches.end(), [&](const LandmarkMatch& m) {
    return usable[static_cast<std::size_t>(m.point)].is_bearing();
  });
  EXPECT_GT(of_bearings, 0.6 * bearings);
  EXPECT_LE(static_cast<int>(matches.size()) - scene.right(usable, matches), 2);
}

// What a point of the world moves by, seen from a robot that goes on by `seconds` of `twist`.
Eigen::Vector3d shift_seen(const Measurement& m, const Vector6d& twist, double seconds) {
  const Eigen::Isometry3d T_later_now = se3_exp(Vector6d(twist * seconds)).inverse();
  if (m.kind == MeasurementKind::point) return T_later_now * m.value - m.value;
  const Eigen::Isometry3d& T = *m.T_robot_camera;
  const Eigen::Vector3d ray(m.value.x(), m.value.y(), 1);
  const Eigen::Vector3d later = T.linear().transpose() * T_later_now.linear() * T.linear() * ray;
  return later / later.z() - ray;
}

TEST(UsableFeatures, MotionWidensByWhatASightMovesInTheUncertaintyOfItsMoment) {
  Scene scene(1);
  for (std::size_t i = 0; i < scene.frame.features.size(); i += 2)
    scene.frame.features[i].kind = MeasurementKind::bearing;
  const auto still = usable_features(scene.frame, scene.settings);
  Vector6d twist;
  twist << 0.4, -0.2, 0.1, 0.3, -0.6, 1.2;
  for (const bool turning : {true, false}) {
    if (!turning) twist.tail<3>().setZero();
    auto moving = still;
    widen_for_motion(twist, 0.01, moving);
    int bearings = 0;
    for (std::size_t i = 0; i < still.size(); ++i) {
      const Measurement &before = still[i].measurement, &after = moving[i].measurement;
      const Eigen::Vector3d shift = 1e3 * shift_seen(before, twist, 1e-5);
      const Eigen::Matrix3d expected = before.covariance + shift * shift.transpose();
      if (turning || !still[i].is_bearing())
        EXPECT_LT((after.covariance - expected).norm(), 1e-3 * shift.squaredNorm() + 1e-15);
      else
        EXPECT_EQ(after.covariance, before.covariance) << "how far it is nobody knows";
      EXPECT_EQ(after.value, before.value);
      bearings += still[i].is_bearing();
    }
    EXPECT_GT(bearings, 10);
    EXPECT_GT(static_cast<int>(still.size()) - bearings, 10);
  }
}

TEST(UsableFeatures, NothingIsWidenedWithoutAMotionOrByAnotherSensorsWord) {
  Scene scene(1);
  const auto still = usable_features(scene.frame, scene.settings);
  Vector6d twist = Vector6d::Ones();
  auto points = still;
  widen_for_motion(twist, 0, points);
  widen_for_motion(Vector6d::Constant(std::numeric_limits<double>::quiet_NaN()), 0.01, points);
  for (FeaturePoint& point : points) point.measurement.kind = MeasurementKind::range_bearing;
  widen_for_motion(twist, 0.01, points);
  for (std::size_t i = 0; i < still.size(); ++i)
    EXPECT_EQ(points[i].measurement.covariance, still[i].measurement.covariance);
}

}  // namespace
}  // namespace lcmslam
