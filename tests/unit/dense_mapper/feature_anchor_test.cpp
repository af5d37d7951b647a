#include <lcmslam/dense_mapper/feature_anchor.hpp>

#include <gmock/gmock.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// A cloud of landmarks with descriptors of their own, and frames that show them.
class AnchorTest : public ::testing::Test {
 protected:
  AnchorTest() {
    for (int i = 0; i < 200; ++i) {
      points_.emplace_back(random_.uniform(-1.5, 1.5), random_.uniform(-1, 1), random_.uniform(2, 4));
      Descriptor descriptor;
      for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(256 * random_.uniform());
      descriptors_.push_back(descriptor);
    }
  }

  /// What a camera there sees, each point with 5 mm of noise; the first `wrong` show other things.
  FeatureFrame frame(const Eigen::Isometry3d& T_world_camera, int wrong = 0) {
    FeatureFrame f;
    f.width = 640;
    f.height = 480;
    f.fx = f.fy = 525;
    f.cx = 319.5;
    f.cy = 239.5;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Feature feature;
      feature.kind = MeasurementKind::point;
      const Eigen::Vector3d noise(random_.normal(), random_.normal(), random_.normal());
      feature.point = (T_world_camera.inverse() * points_[i] + 0.005 * noise).cast<float>();
      if (static_cast<int>(i) < wrong)
        feature.point = {static_cast<float>(random_.uniform(-1.5, 1.5)),
                         static_cast<float>(random_.uniform(-1, 1)),
                         static_cast<float>(random_.uniform(2, 4))};
      feature.depth_sigma = 0.005f;
      feature.descriptor = descriptors_[i];
      f.features.push_back(feature);
    }
    return f;
  }

  Random random_{5};
  std::vector<Eigen::Vector3d> points_;
  std::vector<Descriptor> descriptors_;
  const Eigen::Isometry3d T_robot_camera_ = Eigen::Translation3d(0.2, 0.1, 1.2) * optical_axes();
};

TEST_F(AnchorTest, FindsThePoseThatTheKeyframesExplain) {
  FeatureAnchor anchor({});
  EXPECT_FALSE(
      anchor.locate(frame(Eigen::Isometry3d::Identity()), Eigen::Isometry3d::Identity(), T_robot_camera_));
  anchor.add(Eigen::Isometry3d::Identity(), frame(Eigen::Isometry3d::Identity(), 60));
  anchor.add(se3_exp(twist(0.3, 0, 0, 0, 0.2, 0)), frame(se3_exp(twist(0.3, 0, 0, 0, 0.2, 0)), 40));
  const Eigen::Isometry3d T_world_camera = se3_exp(twist(0.2, -0.1, 0.1, 0.05, 0.15, -0.1));
  const Eigen::Isometry3d T_guess = T_world_camera * se3_exp(twist(0.1, 0.1, -0.1, 0.1, 0, 0.1));
  const auto found = anchor.locate(frame(T_world_camera), T_guess, T_robot_camera_);
  ASSERT_TRUE(found);
  const Eigen::Isometry3d error =
      (T_world_camera * T_robot_camera_.inverse()).inverse() * found->T_target_source;
  EXPECT_LT(error.translation().norm(), 0.01);
  EXPECT_LT(rotation_angle(error), 0.004);
  const Vector6d xi = se3_log(error);
  EXPECT_LT(xi.dot(found->information * xi), 20);  // chi-square, 6 DoF: no more than it claims
}

TEST_F(AnchorTest, SaysNothingWhereTooLittleAgrees) {
  FeatureAnchor anchor({});
  anchor.add(Eigen::Isometry3d::Identity(), frame(Eigen::Isometry3d::Identity(), 190));
  EXPECT_FALSE(
      anchor.locate(frame(Eigen::Isometry3d::Identity()), Eigen::Isometry3d::Identity(), T_robot_camera_));
  EXPECT_FALSE(anchor.locate({}, Eigen::Isometry3d::Identity(), T_robot_camera_));
}

TEST_F(AnchorTest, AsksOnlyKeyframesThatLookTheSameWay) {
  FeatureAnchor anchor({});
  anchor.add(Eigen::Isometry3d::Identity(), frame(Eigen::Isometry3d::Identity()));
  const FeatureFrame seen = frame(Eigen::Isometry3d::Identity());
  EXPECT_TRUE(anchor.locate(seen, Eigen::Isometry3d::Identity(), T_robot_camera_));
  EXPECT_FALSE(anchor.locate(seen, se3_exp(twist(1.5, 0, 0, 0, 0, 0)), T_robot_camera_));
  EXPECT_FALSE(anchor.locate(seen, se3_exp(twist(0, 0, 0, 0, 1, 0)), T_robot_camera_));
  anchor.clear();
  EXPECT_FALSE(anchor.locate(seen, Eigen::Isometry3d::Identity(), T_robot_camera_));
}

// Of 200 matches 60 stay where they are, and more agree on a place half a metre aside: the next tiles.
TEST_F(AnchorTest, DoesNotJumpToThingsThatLookAlikeBesideTheExpectedPlace) {
  FeatureAnchor anchor({});
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  anchor.add(here, frame(here));
  const auto shifted = [&](int from) {
    FeatureFrame seen = frame(here);
    for (std::size_t i = static_cast<std::size_t>(from); i < seen.features.size(); ++i)
      seen.features[i].point.x() += 0.5f;
    return seen;
  };
  const auto beside = anchor.locate(shifted(60), here, T_robot_camera_);
  ASSERT_TRUE(beside);
  EXPECT_LT((beside->T_target_source * T_robot_camera_).translation().norm(), 0.01);
  // Too few agree on the expected place, and not enough of all on the other one.
  FeatureFrame few = shifted(0);
  for (int i = 0; i < 80; ++i)
    few.features[static_cast<std::size_t>(i)].point = {0, 0, 2 + 0.02f * static_cast<float>(i)};
  EXPECT_FALSE(anchor.locate(few, here, T_robot_camera_));
  // All agree: the robot was carried there.
  const auto carried = anchor.locate(shifted(0), here, T_robot_camera_);
  ASSERT_TRUE(carried);
  EXPECT_NEAR((carried->T_target_source * T_robot_camera_).translation().norm(), 0.5, 0.01);
}

TEST_F(AnchorTest, SearchAsksAllKeyframesInTurn) {
  FeatureAnchorSettings settings;
  settings.searched_keyframes = 2;
  FeatureAnchor anchor(settings);
  const FeatureFrame nothing = frame(Eigen::Isometry3d::Identity(), 200);
  EXPECT_FALSE(anchor.search(nothing, T_robot_camera_));
  const Eigen::Isometry3d T_known = se3_exp(twist(3, 1, 0, 0, 2, 0));  // far from anywhere expected
  for (int i = 0; i < 4; ++i) anchor.add(Eigen::Isometry3d::Identity(), nothing);
  FeatureFrame known = frame(Eigen::Isometry3d::Identity());
  anchor.add(T_known, known);
  const Eigen::Isometry3d T_step = se3_exp(twist(0.1, 0, 0.05, 0, 0.1, 0));
  const FeatureFrame seen = frame(T_step);
  EXPECT_FALSE(anchor.search(seen, T_robot_camera_));
  EXPECT_FALSE(anchor.search(seen, T_robot_camera_));
  const auto found = anchor.search(seen, T_robot_camera_);
  ASSERT_TRUE(found);
  const Eigen::Isometry3d error =
      (T_known * T_step * T_robot_camera_.inverse()).inverse() * found->T_target_source;
  EXPECT_LT(error.translation().norm(), 0.02);
}

// Forty matches make a place recognised: where there are hardly any features, nobody can be asked.
TEST_F(AnchorTest, KnowsWhereThereIsNobodyToAsk) {
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  const FeatureFrame rich = frame(here);
  FeatureFrame poor = rich;
  poor.features.resize(79);
  FeatureFrame flat = rich;
  for (Feature& feature : flat.features) feature.kind = MeasurementKind::bearing;
  FeatureAnchor anchor({});
  EXPECT_FALSE(anchor.can_recognise(rich, here)) << "no keyframes";
  anchor.add(here, poor);
  EXPECT_FALSE(anchor.can_recognise(rich, here));
  EXPECT_TRUE(anchor.can_recognise(rich, Eigen::Isometry3d(Eigen::Translation3d(20, 0, 0))))
      << "nobody stands there, which says something";
  anchor.add(here, rich);
  EXPECT_TRUE(anchor.can_recognise(rich, here));
  EXPECT_FALSE(anchor.can_recognise(poor, here));
  EXPECT_FALSE(anchor.can_recognise(flat, here)) << "without depth";
}

TEST_F(AnchorTest, TellsTheCovarianceOfTheRobotNotOfTheCamera) {
  FeatureAnchor anchor({});
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  anchor.add(here, frame(here));
  const FeatureFrame seen = frame(here);
  const auto of_camera = anchor.locate(seen, here, Eigen::Isometry3d::Identity());
  const auto of_robot = anchor.locate(seen, here, T_robot_camera_);
  ASSERT_TRUE(of_camera && of_robot);
  const Matrix6d A = adjoint(T_robot_camera_);
  const Matrix6d expected = A * of_camera->information.inverse() * A.transpose();
  EXPECT_TRUE(of_robot->information.inverse().isApprox(expected, 1e-6));
}

TEST_F(AnchorTest, MovesWithTheGraphsNodes) {
  FeatureAnchor anchor({});
  const Eigen::Isometry3d T_old = se3_exp(twist(1, 0, 0, 0, 0, 0.5)),
                          moved = se3_exp(twist(2, 5, 1, 0.2, 0, 1));
  anchor.add(Eigen::Isometry3d::Identity(), frame(Eigen::Isometry3d::Identity(), 200), 0);
  anchor.add(T_old, frame(Eigen::Isometry3d::Identity()), 1);
  anchor.deform({Eigen::Isometry3d::Identity(), moved});
  const FeatureFrame seen = frame(Eigen::Isometry3d::Identity());
  const auto found = anchor.locate(seen, moved * T_old, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(found);
  EXPECT_LT(se3_log((moved * T_old).inverse() * found->T_target_source).norm(), 0.01);
}

TEST(Fused, LiesBetweenByInformation) {
  Prior a, b;
  a.information = Matrix6d::Identity() * 3;
  b.T_target_source = se3_exp(twist(0.04, 0, 0, 0, 0, 0.02));
  b.information = Matrix6d::Identity();
  const Prior both = fused(a, b);
  EXPECT_TRUE(both.information.isApprox(4 * Matrix6d::Identity()));
  EXPECT_TRUE(se3_log(both.T_target_source).isApprox(twist(0.01, 0, 0, 0, 0, 0.005), 1e-9));
  EXPECT_TRUE(fused(a, Prior()).T_target_source.isApprox(a.T_target_source));  // one that knows nothing

  Random random(2);
  for (int i = 0; i < 20; ++i) {  // minimum of the sum of both squared distances, checked around it
    const auto any = [&] {
      Matrix6d m;
      for (int k = 0; k < 36; ++k) m(k) = random.normal();
      return Matrix6d(m * m.transpose() + Matrix6d::Identity());
    };
    a.information = any();
    b.information = any();
    b.T_target_source = se3_exp(0.001 * any().col(0));
    const Eigen::Isometry3d T = fused(a, b).T_target_source;
    const auto cost = [&](const Eigen::Isometry3d& X) {
      const Vector6d from_a = se3_log(a.T_target_source.inverse() * X),
                     from_b = se3_log(b.T_target_source.inverse() * X);
      return from_a.dot(a.information * from_a) + from_b.dot(b.information * from_b);
    };
    for (int k = 0; k < 6; ++k)
      for (const double step : {-1e-3, 1e-3})
        EXPECT_GT(cost(T * se3_exp(step * Vector6d::Unit(k))), cost(T)) << i << " " << k;
  }
}

}  // namespace
}  // namespace lcmslam
