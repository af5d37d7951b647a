// Rows that were read one after the other.

#include <lcmslam/rgbd/rolling_shutter.hpp>

#include <gtest/gtest.h>

#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

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

// A robot that turns left by 0.5 rad/s, its camera ahead; the image takes 40 ms.
TEST(RollingShutter, TakesTheMotionFromOdometry) {
  MotionBuffer odometry;
  for (Utime t = 0; t <= 1'000'000; t += 20'000)
    odometry.add({t, planar_pose(0, 0, 0.5e-6 * static_cast<double>(t)), Matrix6d::Zero()});
  FeatureFrame frame;
  frame.utime = 1'000'000;
  frame.width = 640, frame.height = 480;
  frame.fx = frame.fy = 500, frame.cx = 319.5, frame.cy = 239.5;
  Feature first_row;
  first_row.x = 319.5F, first_row.y = 0;
  first_row.kind = MeasurementKind::point;
  first_row.point = {0, -1, 2};
  frame.features.push_back(first_row);
  first_row.kind = MeasurementKind::bearing;
  first_row.point.setConstant(std::numeric_limits<float>::quiet_NaN());
  frame.features.push_back(first_row);
  FeatureFrame straight = frame, unknown = frame;
  straighten_rows(straight, odometry, 0.04);
  // 20 ms before the middle the camera looked 10 mrad farther to the right: what was ahead of it lies right
  // of the image's middle.
  EXPECT_NEAR(straight.features[0].point.x(), 2 * 0.01, 2e-4);
  EXPECT_NEAR(straight.features[1].x, 319.5 + 500 * 0.01, 0.1);
  EXPECT_NEAR(straight.features[1].y, 0, 0.1);
  for (const double shutter : {0.0, 0.04}) {
    straighten_rows(unknown, shutter > 0 ? MotionBuffer() : odometry, shutter);
    EXPECT_EQ(unknown.features[0].point, frame.features[0].point);
    EXPECT_EQ(unknown.features[1].x, frame.features[1].x);
  }
}

}  // namespace
}  // namespace lcmslam
