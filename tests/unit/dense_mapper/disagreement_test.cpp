// Odometry and features that tell different places: the map judges.

#include <gtest/gtest.h>

#include <cmath>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

class Disagreement : public testing::Test {
 protected:
  Disagreement() {
    looks_ahead_.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    for (int i = 0; i < 150; ++i) {
      landmarks_.push_back(scene_.points[random_.below(scene_.size())].cast<double>());
      Descriptor descriptor;
      for (auto& byte : descriptor) byte = static_cast<std::uint8_t>(256 * random_.uniform());
      descriptors_.push_back(descriptor);
    }
  }

  ColouredCloud cloud_at(const Eigen::Isometry3d& T_world_robot) {
    ColouredCloud cloud;
    const Eigen::Isometry3f T = (T_world_robot * looks_ahead_).inverse().cast<float>();
    for (std::size_t i = 0; i < scene_.size(); ++i) {
      const Eigen::Vector3f p = T * scene_.points[i];
      if (p.z() < 0.2f || std::abs(p.x()) > 0.8f * p.z() || std::abs(p.y()) > 0.6f * p.z()) continue;
      const Eigen::Vector3f n = T.linear() * scene_.normals[i];
      cloud.points.push_back(p + static_cast<float>(random_.normal(0, 0.003)) * n);
      cloud.normals.push_back(n);
      cloud.sigmas.push_back(0.003f);
      cloud.colours.emplace_back(10, 20, 30);
    }
    return cloud;
  }

  FeatureFrame features_at(const Eigen::Isometry3d& T_world_robot) {
    FeatureFrame frame;
    frame.width = 640;
    frame.height = 480;
    frame.fx = frame.fy = 525;
    frame.cx = 319.5;
    frame.cy = 239.5;
    const Eigen::Isometry3d T = (T_world_robot * looks_ahead_).inverse();
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      Feature feature;
      feature.kind = MeasurementKind::point;
      feature.point = (T * landmarks_[i]).cast<float>();
      feature.depth_sigma = 0.005f;
      feature.descriptor = descriptors_[i];
      frame.features.push_back(feature);
    }
    return frame;
  }

  /// The step after the first, 5 cm ahead, with what odometry and features say of it (m ahead).
  DenseMapper::Step second_step(double by_odometry, double by_features, double max_disagreement = 5) {
    DenseMapperSettings settings;
    settings.features.max_disagreement = max_disagreement;
    DenseMapper mapper(settings);
    DenseFrame first = coloured_frame(0, cloud_at(Eigen::Isometry3d::Identity()), looks_ahead_);
    first.features = features_at(Eigen::Isometry3d::Identity());
    mapper.step(first);
    Motion motion;
    motion.T_from_to = planar_pose(by_odometry, 0, 0);
    motion.covariance = 1e-4 * Matrix6d::Identity();
    DenseFrame second = coloured_frame(100'000, cloud_at(planar_pose(0.05, 0, 0)), looks_ahead_, motion);
    second.features = features_at(planar_pose(by_features, 0, 0));
    return mapper.step(second);
  }

  const Cloud scene_ = room(0.03);
  Eigen::Isometry3d looks_ahead_ = Eigen::Isometry3d::Identity();
  Random random_{4};
  std::vector<Eigen::Vector3d> landmarks_;
  std::vector<Descriptor> descriptors_;
};

TEST_F(Disagreement, BothAreFusedWhereTheyAgree) {
  const auto step = second_step(0.055, 0.05);
  EXPECT_TRUE(step.anchored);
  EXPECT_EQ(to_string(step.status), "tracking");
  EXPECT_NEAR(step.T_world_robot.translation().x(), 0.05, 0.004);
}

TEST_F(Disagreement, FeaturesAreBelievedWhereWheelsSlipped) {
  const auto step = second_step(0.6, 0.05);
  EXPECT_TRUE(step.anchored);
  EXPECT_EQ(to_string(step.status), "tracking");
  EXPECT_NEAR(step.T_world_robot.translation().x(), 0.05, 0.006);
}

TEST_F(Disagreement, OdometryIsBelievedWhereFeaturesMovedAlong) {
  const auto step = second_step(0.055, 0.45);
  EXPECT_FALSE(step.anchored);
  EXPECT_EQ(to_string(step.status), "tracking");
  EXPECT_NEAR(step.T_world_robot.translation().x(), 0.05, 0.006);
  // The mean of both is no place at all.
  const auto fused = second_step(0.055, 0.45, 1e6);
  EXPECT_GT(std::abs(fused.T_world_robot.translation().x() - 0.05), 0.02);
}

}  // namespace
}  // namespace lcmslam
