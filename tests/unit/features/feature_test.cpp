#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <lcmslam/features/feature.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {
namespace {

TEST(DescriptorBytes, RoundAndClamp) {
  float components[64] = {};
  components[1] = 1;
  components[2] = -1;
  components[3] = 0.5f / 127 + 1e-4f;  // just above a half
  components[4] = 0.5f / 127 - 1e-4f;
  components[5] = 2;
  components[6] = -2;
  components[7] = std::numeric_limits<float>::quiet_NaN();
  components[8] = std::numeric_limits<float>::infinity();
  components[9] = -std::numeric_limits<float>::infinity();
  const Descriptor bytes = to_bytes(components);
  EXPECT_EQ(bytes[0], 128);
  EXPECT_EQ(bytes[1], 255);
  EXPECT_EQ(bytes[2], 1);
  EXPECT_EQ(bytes[3], 129);
  EXPECT_EQ(bytes[4], 128);
  EXPECT_EQ(bytes[5], 255);
  EXPECT_EQ(bytes[6], 0);
  EXPECT_EQ(bytes[7], 0);
  EXPECT_EQ(bytes[8], 255);
  EXPECT_EQ(bytes[9], 0);
  EXPECT_EQ(bytes[63], 128);
}

TEST(DescriptorBytes, LoseAtMostHalfAStep) {
  Random random(1);
  float components[64];
  for (float& c : components) c = static_cast<float>(random.uniform(-1, 1));
  const Descriptor bytes = to_bytes(components);
  for (std::size_t k = 0; k < 64; ++k) EXPECT_NEAR((bytes[k] - 128) / 127., components[k], 0.5 / 127 + 1e-6);
}

FeatureFrame kinect() {
  FeatureFrame frame;
  frame.fx = 520;
  frame.fy = 510;
  frame.pixel_sigma = 1.5;
  return frame;
}

Feature point_at(float x, float y, float z, float depth_sigma) {
  Feature feature;
  feature.kind = MeasurementKind::point;
  feature.point = {x, y, z};
  feature.depth_sigma = depth_sigma;
  return feature;
}

TEST(PointCovariance, LiesAlongTheRay) {
  const Feature feature = point_at(0.7f, -0.4f, 2.f, 0.02f);
  const Eigen::Matrix3d covariance = point_covariance(feature, kinect());
  const Eigen::Vector3d ray = feature.point.cast<double>().normalized();
  EXPECT_NEAR((covariance * ray - 0.02 * 0.02 * ray).norm(), 0, 1e-9);
  const double across = 1.5 * 2 / 515;
  for (int axis : {0, 1}) {
    const Eigen::Vector3d side = ray.cross(Eigen::Vector3d::Unit(axis)).normalized();
    EXPECT_NEAR((covariance * side - across * across * side).norm(), 0, 1e-9);
  }
  EXPECT_EQ(covariance, covariance.transpose());
}

TEST(PointCovariance, OnTheAxisIsDiagonal) {
  const Eigen::Matrix3d covariance = point_covariance(point_at(0, 0, 3, 0.05f), kinect());
  const double across = 1.5 * 3 / 515;
  const Eigen::Vector3d expected(across * across, across * across, 0.05 * 0.05);
  EXPECT_LT((covariance - Eigen::Matrix3d(expected.asDiagonal())).norm(), 1e-9);
}

TEST(PointCovariance, GrowsAcrossTheRayWithTheBlob) {
  const FeatureFrame frame = kinect();
  Feature feature = point_at(0, 0, 3, 0.05f);
  EXPECT_EQ(pixel_sigma(feature, frame), 1.5);  // nobody told how large it is
  const auto across = [&](float size) {
    feature.size = size;
    return std::sqrt(point_covariance(feature, frame)(0, 0)) * 515 / 3;
  };
  EXPECT_NEAR(across(25), 1.5, 1e-6);
  EXPECT_NEAR(across(75), 3 * 1.5, 1e-6);
  EXPECT_NEAR(across(9), 0.7 * 1.5, 1e-6);
  EXPECT_NEAR(across(5), across(9), 1e-9);
}

TEST(PointCovariance, RefusesWhatHasNone) {
  EXPECT_THROW(point_covariance(Feature{}, kinect()), std::invalid_argument);
  EXPECT_THROW(point_covariance(point_at(0, 0, -1, 0.1f), kinect()), std::invalid_argument);
  EXPECT_THROW(point_covariance(point_at(0, 0, 1, NAN), kinect()), std::invalid_argument);
  EXPECT_THROW(point_covariance(point_at(0, 0, 1, 0.1f), FeatureFrame{}), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
