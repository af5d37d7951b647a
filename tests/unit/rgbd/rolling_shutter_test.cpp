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

}  // namespace
}  // namespace lcmslam
