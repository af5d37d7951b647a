// Images of different moments: the depth's clock, features placed by depth that was moved, rows read one
// after the other.

#include <gmock/gmock.h>

#include <lcmslam/rgbd/depth_clock.hpp>
#include <lcmslam/rgbd/feature_depth.hpp>
#include <lcmslam/rgbd/rolling_shutter.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

TEST(DepthClock, FindsTheOffsetFromTurns) {
  for (const double offset : {-0.014, 0.0, 0.008}) {
    DepthClock clock({});
    Random random(3);
    for (int i = 0; i < 600; ++i) {
      const Eigen::Vector3d omega(0.5 * std::sin(0.1 * i), std::cos(0.07 * i), 0.3);  // rad/s
      const auto turned = [&](double seconds) {
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() = so3_exp(omega * seconds);
        return T;
      };
      const Eigen::Vector3d noise(random.normal(0, 0.01), random.normal(0, 0.01), random.normal(0, 0.01));
      const Eigen::Isometry3d T = se3_exp(twist(1, 2, 0, 0.4, 0.1 * i, 0));
      clock.add(T * se3_exp(twist(0, 0, 0, noise.x(), noise.y(), noise.z())),
                T * turned(offset - clock.offset()), omega);
    }
    EXPECT_NEAR(clock.offset(), offset, 3 * clock.sigma());
    EXPECT_LT(clock.sigma(), 0.0015);
  }
}

TEST(DepthClock, StaysWhereNothingTurnsAndIgnoresWhatIsNoClock) {
  DepthClock clock({});
  const Eigen::Isometry3d far = se3_exp(twist(0, 0, 0, 0, 0.5, 0));
  for (int i = 0; i < 100; ++i) {
    clock.add(Eigen::Isometry3d::Identity(), se3_exp(twist(0, 0, 0, 0, 0.01, 0)), Eigen::Vector3d::Zero());
    clock.add(Eigen::Isometry3d::Identity(), far, {0, 1, 0});
  }
  EXPECT_EQ(clock.offset(), 0);
  EXPECT_DOUBLE_EQ(clock.sigma(), DepthClockSettings().prior);
}

/// A wall 2 m ahead with a board in front of its right half, as a depth camera of 160 x 120 sees it.
struct Wall {
  CameraModel camera;
  RegisteredDepth depth;

  Wall() {
    camera.width = 160;
    camera.height = 120;
    camera.fx = camera.fy = 130;
    camera.cx = 79.5;
    camera.cy = 59.5;
    depth.points.create(120, 160, CV_32FC3);
    depth.sigma = cv::Mat(120, 160, CV_32FC1, cv::Scalar(0.005));
    for (int v = 0; v < 120; ++v)
      for (int u = 0; u < 160; ++u) {
        const double z = u < 100 ? 2.0 : 1.0;
        const Eigen::Vector3d p = z * camera.ray({u, v});
        depth.points.at<cv::Vec3f>(v, u) = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                                            static_cast<float>(p.z())};
      }
  }

  FeatureFrame features(std::vector<float> columns) const {
    FeatureFrame f;
    f.fx = f.fy = 130;
    f.cx = 79.5;
    f.cy = 59.5;
    for (const float x : columns) {
      Feature feature;
      feature.x = x;
      feature.y = 40;
      feature.kind = MeasurementKind::point;
      feature.point = {0, 0, 1.5f};
      feature.depth_sigma = 1;
      f.features.push_back(feature);
    }
    return f;
  }
};

TEST(FeatureDepth, ReadsWhereTheFeatureWas) {
  const Wall wall;
  const auto still =
      placed_by(wall.depth, wall.camera, Eigen::Isometry3d::Identity(), wall.features({50, 99.5f, 130}));
  EXPECT_NEAR(still.features[0].point.z(), 2, 1e-3);
  EXPECT_NEAR(still.features[0].point.x(), 2 * (50 - 79.5) / 130, 1e-3);
  EXPECT_FLOAT_EQ(still.features[0].depth_sigma, 0.005f);
  EXPECT_EQ(still.features[1].kind, MeasurementKind::bearing);  // on the edge
  EXPECT_TRUE(std::isnan(still.features[1].point.x()));
  EXPECT_NEAR(still.features[2].point.z(), 1, 1e-3);
  // The depth camera has turned right by 0.15 rad, about 20 pixels: the feature's place was seen 20 pixels
  // farther left.
  Eigen::Isometry3d T_depth_colour = Eigen::Isometry3d::Identity();
  T_depth_colour.linear() = so3_exp({0, -0.15, 0});
  const auto turned = placed_by(wall.depth, wall.camera, T_depth_colour, wall.features({112}));
  EXPECT_NEAR(turned.features[0].point.z(), 2, 1e-3);
}

TEST(RollingShutter, StraightensWhatTurningSheared) {
  // A vertical line seen while the camera turns about y by 0.1 rad from the first row to the last.
  const Vector6d motion = twist(0.02, 0, 0, 0, 0.1, 0);
  cv::Mat points(100, 1, CV_32FC3);
  for (int v = 0; v < 100; ++v) {
    const Eigen::Isometry3d T_middle_row = se3_exp(((v + 0.5) / 100 - 0.5) * motion);
    const Eigen::Vector3d p = T_middle_row.inverse() * Eigen::Vector3d(0.1, 0.02 * (v - 50), 2);
    points.at<cv::Vec3f>(v, 0) = {static_cast<float>(p.x()), static_cast<float>(p.y()),
                                  static_cast<float>(p.z())};
  }
  EXPECT_GT(std::abs(points.at<cv::Vec3f>(0, 0)[0] - points.at<cv::Vec3f>(99, 0)[0]), 0.15);
  FeatureFrame features;
  features.height = 100;
  Feature feature;
  feature.kind = MeasurementKind::point;
  feature.y = 99;
  feature.point = {points.at<cv::Vec3f>(99, 0)[0], points.at<cv::Vec3f>(99, 0)[1],
                   points.at<cv::Vec3f>(99, 0)[2]};
  features.features.push_back(feature);
  straighten_rows(points, motion);
  straighten_rows(features, motion);
  for (int v = 0; v < 100; ++v) {
    EXPECT_NEAR(points.at<cv::Vec3f>(v, 0)[0], 0.1, 1e-5);
    EXPECT_NEAR(points.at<cv::Vec3f>(v, 0)[2], 2, 1e-5);
  }
  EXPECT_NEAR(features.features[0].point.x(), 0.1, 1e-5);
  straighten_rows(points, Vector6d::Zero());
  EXPECT_NEAR(points.at<cv::Vec3f>(0, 0)[0], 0.1, 1e-5);
}

}  // namespace
}  // namespace lcmslam
