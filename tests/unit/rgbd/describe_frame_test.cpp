#include <lcmslam/rgbd/describe_frame.hpp>

#include <gtest/gtest.h>

#include "tests/support/analytic_scene.hpp"

namespace lcmslam {
namespace {

/// Finds what it is told to, with descriptors of a length.
class GivenKeypoints : public cv::Feature2D {
 public:
  GivenKeypoints(std::vector<cv::KeyPoint> keypoints, int length)
      : keypoints_(std::move(keypoints)), length_(length) {}
  void detectAndCompute(cv::InputArray, cv::InputArray, std::vector<cv::KeyPoint>& keypoints,
                        cv::OutputArray descriptors, bool) override {
    keypoints = keypoints_;
    cv::Mat(static_cast<int>(keypoints.size()), length_, CV_32FC1, cv::Scalar(0.125)).copyTo(descriptors);
  }

 private:
  std::vector<cv::KeyPoint> keypoints_;
  int length_;
};

class DescribeFrame : public testing::Test {
 protected:
  DescribeFrame() {
    testing_scene::Scene scene;
    scene.planes = {{{0, 0, 1}, 2}};
    frame_.utime = 7;
    frame_.colour = cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 2, 3));
    frame_.depth = testing_scene::render(scene, calibration_.depth, Eigen::Isometry3d::Identity());
    frame_.depth.colRange(0, 100).setTo(0);
  }
  FeatureFrame describe(const std::vector<cv::KeyPoint>& keypoints, int length = 64) const {
    GivenKeypoints detector(keypoints, length);
    return describe_frame(frame_, register_depth(frame_, calibration_), calibration_, detector);
  }

  RgbdCalibration calibration_ = testing_scene::registered_head();
  RgbdFrame frame_;
};

TEST_F(DescribeFrame, FeaturesStandWhereDepthIsAndOnTheRayWhereNoneIs) {
  const cv::KeyPoint seen({420.5f, 130.25f}, 12, 90, 55, 2, -1), blind({50, 240}, 9);
  const FeatureFrame features = describe({seen, blind});
  EXPECT_EQ(features.utime, 7);
  EXPECT_EQ(features.fx, calibration_.colour.fx);
  ASSERT_EQ(features.features.size(), 2U);
  const Feature& f = features.features[0];
  EXPECT_EQ(f.kind, MeasurementKind::point);
  const Eigen::Vector3d ray = calibration_.colour.ray({420.5, 130.25});
  EXPECT_LT((f.point.cast<double>() - 2 * ray).norm(), 0.002);
  EXPECT_NEAR(static_cast<double>(f.x), features.cx + features.fx * ray.x(), 0.01) << "without the lens";
  EXPECT_NEAR(static_cast<double>(f.angle), CV_PI / 2, 1e-6);
  EXPECT_EQ(f.octave, 2);
  EXPECT_EQ(f.laplacian, -1);
  EXPECT_EQ(f.descriptor[0], 128 + 16);
  EXPECT_EQ(f.colour, (decltype(f.colour){3, 2, 1}));
  EXPECT_EQ(features.features[1].kind, MeasurementKind::bearing);
}

TEST_F(DescribeFrame, DescriptorsOfAnotherLengthAreRefused) {
  EXPECT_THROW(describe({cv::KeyPoint({320, 240}, 9)}, 32), std::invalid_argument);
  EXPECT_NO_THROW(describe({}, 32));
}

}  // namespace
}  // namespace lcmslam
