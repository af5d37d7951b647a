// What a robot's camera does to images: blur, darkness, edges without blobs.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"

namespace lcmslam {
namespace {

struct SoundFeatures {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;

  explicit SoundFeatures(const cv::Mat& image, SurfSettings settings = {}) {
    settings.budget.max_features = 0;
    Surf(settings).detectAndCompute(image, cv::noArray(), keypoints, descriptors);
    EXPECT_TRUE(cv::checkRange(descriptors));
    for (const cv::KeyPoint& k : keypoints) {
      EXPECT_TRUE(std::isfinite(k.pt.x) && std::isfinite(k.pt.y) && k.size > 0 && k.response > 0);
      EXPECT_TRUE(k.angle >= 0 && k.angle <= 360);
    }
  }
};

TEST(SurfDegradation, MotionBlurLeavesFewerFeatures) {
  const cv::Mat sharp = test::random_scene(41, 200, 900).draw(400, 300, {0.6, 0, 200, 150});
  std::size_t before = SoundFeatures(sharp).keypoints.size();
  EXPECT_GT(before, 100u);
  for (const int length : {9, 21, 45, 91}) {
    cv::Mat blurred;
    cv::blur(sharp, blurred, {length, 1});
    const std::size_t left = SoundFeatures(blurred).keypoints.size();
    EXPECT_LT(left, before) << length << " pixels";
    before = left;
  }
}

TEST(SurfDegradation, LowContrastLeavesFewerFeatures) {
  const test::BlobScene scene = test::random_scene(42, 200, 600);
  std::size_t before = 1e6;
  for (const double contrast : {1., 0.7, 0.5, 0.35, 0.25}) {
    const std::size_t left =
        SoundFeatures(scene.draw(400, 300, {1, 0, 200, 150}, contrast, 60)).keypoints.size();
    EXPECT_LT(left, before) << contrast;
    before = left;
  }
  EXPECT_EQ(SoundFeatures(scene.draw(400, 300, {1, 0, 200, 150}, 0.01, 60)).keypoints.size(), 0u);
}

// The same profile across, but one is three or six times as long as the other: at the size of its width it
// has no place along itself. Twice as long is a blob still.
TEST(SurfDegradation, EdgesAreNoBlobs) {
  SurfSettings every;
  every.hessian_threshold = 20;
  every.edge_ratio = 1e6;
  SurfSettings usual = every;
  usual.edge_ratio = SurfSettings{}.edge_ratio;
  const auto near_centre = [](const SoundFeatures& features) {
    return std::count_if(features.keypoints.begin(), features.keypoints.end(), [](const auto& k) {
      return cv::norm(k.pt - cv::Point2f(150, 150)) < 8 && k.size < 30;
    });
  };
  long on_lines = 0;
  for (int degrees = 0; degrees < 180; degrees += 10) {
    const double angle = degrees * M_PI / 180;
    const auto drawn = [angle](double length) {
      return test::BlobScene{{{150, 150, length, 4, angle, 90}}}.draw(301, 301);
    };
    for (const double length : {4, 8})
      EXPECT_GE(near_centre(SoundFeatures(drawn(length), usual)), 1) << length << ", " << degrees;
    for (const double length : {12, 24}) {
      on_lines += near_centre(SoundFeatures(drawn(length), every));
      EXPECT_EQ(near_centre(SoundFeatures(drawn(length), usual)), 0) << length << ", " << degrees;
    }
  }
  EXPECT_GT(on_lines, 5);  // that is what the ratio rejects
}

}  // namespace
}  // namespace lcmslam
