// Descriptors against their definition.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/surf/descriptor.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"
#include "tests/unit/surf/detected_features.hpp"
#include "tests/unit/surf/plain_descriptor.hpp"

namespace lcmslam {
namespace {

using namespace test;

// Of all sizes: the small blobs' boxes come from the image, the large ones' from its coarser copies.
TEST(SurfDescriptor, EqualsThePlainReference) {
  const cv::Mat drawn = random_scene(11, 160).draw(323, 261, {1, 0, 160, 130});
  for (const auto& [extended, smooth] :
       {std::pair(false, false), std::pair(false, true), std::pair(true, true)}) {
    SurfSettings settings;
    settings.extended = extended;
    settings.smooth = smooth;
    const Features features(drawn, settings);
    BinomialSmoother smoother;
    const cv::Mat image = smooth ? smoother.smooth(drawn) : drawn;
    ASSERT_GT(features.keypoints.size(), 80u);
    ASSERT_EQ(features.descriptors.cols, extended ? 128 : 64);
    int large = 0, decided = 0, components = 0;
    for (std::size_t k = 0; k < features.keypoints.size(); ++k) {
      const cv::KeyPoint& p = features.keypoints[k];
      const double s = 1.2 * (smooth ? double(smoothed_size(p.size)) : p.size) / 9;
      const double width = 1.35 * pitch * s, fraction = width - std::floor(width);
      if (std::abs(fraction - 0.5) < 1e-4) continue;  // rounds this way or that
      large += width >= 5.5;
      Vector slack(extended ? 0 : 64);
      const Vector expected =
          plain_descriptor(image, p.pt.x, p.pt.y, s, p.angle * M_PI / 180, extended, &slack);
      double norm_slack = 0;  // one undecided sum changes the norm, and with it every component
      for (std::size_t i = 0; i < expected.size(); ++i) norm_slack += slack[i] * std::abs(expected[i]);
      for (std::size_t i = 0; i < expected.size(); ++i) {
        ASSERT_NEAR(features.descriptors.at<float>(int(k), int(i)), expected[i],
                    5e-4 + slack[i] + norm_slack * std::abs(expected[i]))
            << "component " << i << " of " << p.pt << ", size " << p.size;
        decided += slack[i] == 0;
      }
      components += int(expected.size());
    }
    EXPECT_GT(decided, 0.9 * components);
    EXPECT_GT(large, 20);
  }
}

TEST(SurfDescriptor, IsTheTurnedWaveletsOfItsDefinition) {
  const BlobScene scene = random_scene(12, 400, 900);
  const cv::Mat_<double> exact = scene.draw_exact(700, 700, {1, 0, 350, 350});
  cv::Mat image;
  exact.convertTo(image, CV_8U);
  SurfSettings settings;
  settings.smooth = false;
  const Features features(image, settings);
  int compared = 0;
  double sum = 0, worst = 1;
  for (std::size_t k = 0; k < features.keypoints.size(); ++k) {
    const cv::KeyPoint& p = features.keypoints[k];
    const double s = 1.2 * p.size / 9, reach = 16 * s;
    if (p.pt.x < reach || p.pt.y < reach || p.pt.x > 698 - reach || p.pt.y > 698 - reach) continue;
    const Vector ideal = ideal_descriptor(exact, p.pt.x, p.pt.y, s, p.angle * M_PI / 180);
    const double similarity = cosine(ideal, features.descriptors.ptr<float>(int(k)));
    sum += similarity;
    worst = std::min(worst, similarity);
    ++compared;
  }
  ASSERT_GT(compared, 150);
  std::printf("[          ] %d descriptors: cosine to the ideal mean %.5f, worst %.5f\n", compared,
              sum / compared, worst);
  EXPECT_GT(sum / compared, 0.995);
  EXPECT_GT(worst, 0.95);
}

TEST(SurfDescriptor, HasUnitNormOrIsZeroWhereFlat) {
  const cv::Mat image = random_scene(13, 100).draw(200, 200, {1, 0, 100, 100});
  Features features(image);
  ASSERT_GT(features.descriptors.rows, 20);
  for (int k = 0; k < features.descriptors.rows; ++k)
    EXPECT_NEAR(cv::norm(features.descriptors.row(k)), 1, 1e-5);
  for (float size : {9.f, 200.f}) {
    std::vector<cv::KeyPoint> provided{cv::KeyPoint(50.3f, 40.7f, size), cv::KeyPoint(-1000.f, 1e6f, size)};
    cv::Mat descriptors;
    Surf().compute(cv::Mat(100, 100, CV_8UC1, cv::Scalar(90)), provided, descriptors);
    ASSERT_EQ(descriptors.rows, 2);
    EXPECT_EQ(cv::norm(descriptors, cv::NORM_INF), 0);
    EXPECT_EQ(provided[0].angle, 0);
  }
}

TEST(SurfDescriptor, DetectThenComputeEqualsBothAtOnce) {
  const cv::Mat image = random_scene(14, 100).draw(200, 180, {1, 0, 100, 100});
  Features at_once(image);
  Surf surf;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  surf.detect(image, keypoints);
  surf.compute(image, keypoints, descriptors);
  ASSERT_EQ(descriptors.size(), at_once.descriptors.size());
  EXPECT_LT(cv::norm(descriptors, at_once.descriptors, cv::NORM_INF), 1e-5);
  EXPECT_EQ(descriptors.type(), CV_32F);
  EXPECT_EQ(descriptors.cols, surf.descriptorSize());
}

TEST(SurfDescriptor, UprightLeavesTheAngleAtZero) {
  SurfSettings settings;
  settings.upright = true;
  const cv::Mat image = random_scene(15, 100).draw(200, 180, {1, 0, 100, 100});
  const Features upright(image, settings), turned(image);
  ASSERT_EQ(upright.keypoints.size(), turned.keypoints.size());
  for (const auto& k : upright.keypoints) EXPECT_EQ(k.angle, 0);
  const cv::KeyPoint& p = upright.keypoints[0];
  const Vector expected = plain_descriptor(BinomialSmoother().smooth(image).clone(), p.pt.x, p.pt.y,
                                           1.2 * double(smoothed_size(p.size)) / 9, 0);
  EXPECT_GT(cosine(expected, upright.descriptors.ptr<float>(0)), 0.9999);
}

}  // namespace
}  // namespace lcmslam
