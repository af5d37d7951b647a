// Odometry and features that tell different places: the map judges.

#include <gtest/gtest.h>

#include <algorithm>
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

  FeatureFrame features_at(const Eigen::Isometry3d& T_world_robot, std::size_t most = 1000) {
    FeatureFrame frame;
    frame.width = 640;
    frame.height = 480;
    frame.fx = frame.fy = 525;
    frame.cx = 319.5;
    frame.cy = 239.5;
    const Eigen::Isometry3d T = (T_world_robot * looks_ahead_).inverse();
    for (std::size_t i = 0; i < std::min(most, landmarks_.size()); ++i) {
      Feature feature;
      feature.kind = MeasurementKind::point;
      feature.point = (T * landmarks_[i]).cast<float>();
      feature.depth_sigma = 0.005f;
      feature.descriptor = descriptors_[i];
      frame.features.push_back(feature);
    }
    return frame;
  }

  static Motion still() {
    Motion motion;
    motion.covariance = 1e-6 * Matrix6d::Identity();
    return motion;
  }

  /// Of a robot there, with so many features.
  DenseFrame frame_at(Utime utime, const Eigen::Isometry3d& T_world_robot, std::size_t features,
                      const std::optional<Motion>& motion = std::nullopt) {
    DenseFrame frame = coloured_frame(utime, cloud_at(T_world_robot), looks_ahead_, motion);
    if (features > 0) frame.features = features_at(T_world_robot, features);
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

// After a gap it may be anywhere: what twenty or thirty features say of it counts as soon as they place it,
// and not before.
TEST_F(Disagreement, FeaturesThatPlaceNobodyMakeNobodySure) {
  DenseMapper mapper{DenseMapperSettings()};
  mapper.step(frame_at(0, Eigen::Isometry3d::Identity(), 150));
  const double gap = 5;  // s without frames and odometry
  const auto step = mapper.step(frame_at(static_cast<Utime>(1e6 * gap), planar_pose(0.1, 0, 0), 30));
  ASSERT_TRUE(step.adrift);
  ASSERT_EQ(to_string(step.status), "lost");
  EXPECT_GT(step.covariance(0, 0), 0.25 * gap * gap) << "half a metre a second";
}

// Three dark frames, nobody tells how it moves, and then features find it where it has gone. That is no
// motion of a tenth of a second, which would go on.
TEST_F(Disagreement, WhoIsFoundByFeaturesIsRelocalised) {
  DenseMapper mapper{DenseMapperSettings()};
  mapper.step(frame_at(0, Eigen::Isometry3d::Identity(), 150));
  for (int i = 1; i <= 3; ++i)
    EXPECT_TRUE(mapper.step(coloured_frame(100'000 * i, ColouredCloud(), looks_ahead_)).blind);
  const Eigen::Isometry3d gone = planar_pose(0.6, 0, 0);
  const auto step = mapper.step(frame_at(400'000, gone, 150));
  EXPECT_EQ(to_string(step.status), "tracking");
  EXPECT_NEAR(step.T_world_robot.translation().x(), 0.6, 0.02);
  EXPECT_TRUE(step.relocalised);
  // It stands there, and goes on from there.
  const auto next = mapper.step(frame_at(500'000, gone, 0));
  EXPECT_EQ(to_string(next.status), "tracking");
  EXPECT_NEAR(next.T_world_robot.translation().x(), 0.6, 0.02);
}

// Carried while its wheels stand still, and found: news of the map, no motion. A controller sees no jump.
TEST_F(Disagreement, ACarriedRobotThatIsFoundHasNotMovedForItsController) {
  DenseMapperSettings settings;
  DenseMapper mapper(settings);
  mapper.step(frame_at(0, Eigen::Isometry3d::Identity(), 150));
  Eigen::Isometry3d T_last = Eigen::Isometry3d::Identity();
  double farthest = 0;
  const auto look = [&](const DenseFrame& frame) {
    const DenseMapper::Step step = mapper.step(frame);
    farthest = std::max(farthest, distance_between(T_last, step.T_local_robot));
    T_last = step.T_local_robot;
    return step;
  };
  const Cloud elsewhere = transformed(room(0.03), planar_pose(0.3, 0.2, 3.0));
  Utime utime = 0;
  DenseMapper::Step step;
  for (int i = 0; i < 40 && !step.carried; ++i) {
    ColouredCloud seen;
    for (std::size_t k = 0; k < elsewhere.size(); ++k) {
      const Eigen::Isometry3f T = looks_ahead_.inverse().cast<float>();
      seen.points.push_back(T * elsewhere.points[k]);
      seen.normals.push_back(T.linear() * elsewhere.normals[k]);
      seen.sigmas.push_back(0.003f);
      seen.colours.emplace_back(10, 20, 30);
    }
    step = look(coloured_frame(utime += 100'000, seen, looks_ahead_, still()));
  }
  ASSERT_TRUE(step.carried);
  const Eigen::Isometry3d there = planar_pose(0.5, 0.3, 0.2);
  for (int i = 0; i < 5 && to_string(step.status) != "tracking"; ++i)
    step = look(frame_at(utime += 100'000, there, 150, still()));
  ASSERT_EQ(to_string(step.status), "tracking");
  EXPECT_LT(distance_between(step.T_world_robot, there), 0.02);
  EXPECT_LT(distance_between(step.T_world_local * step.T_local_robot, there), 0.02);
  EXPECT_LT(farthest, 4 * settings.prior.floor_translation);
}

}  // namespace
}  // namespace lcmslam
