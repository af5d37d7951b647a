#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <lcmslam/parallel/shared_processors.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"

namespace lcmslam {
namespace {

using test::BlobScene;
using test::random_scene;

std::vector<cv::KeyPoint> detect(const cv::Mat& image, SurfSettings settings = {}, const cv::Mat& mask = {}) {
  std::vector<cv::KeyPoint> keypoints;
  Surf(settings).detect(image, keypoints, mask);
  return keypoints;
}

SurfSettings unlimited(double threshold = 100) {
  SurfSettings settings;
  settings.hessian_threshold = threshold;
  settings.budget.max_features = 0;
  return settings;
}

// At the centre of a Gaussian blob Dxy is 0 and Dxx = Dyy is a product of error functions: where it
// peaks over the filter's side is the size to expect (near 5.3 sigma: boxes see less of a blob's flanks
// than Gaussian derivatives, which would give 7.5 sigma).
double expected_size(double sigma) {
  const auto within = [&](double half) { return std::erf(half / (std::sqrt(2.) * sigma)); };
  double best_size = 0, best_response = 0;
  for (double lobe = 2; lobe < 70; lobe += 0.01) {
    const double response = (3 * within(lobe / 2) - within(1.5 * lobe)) * within(lobe - 0.5) /
                            (lobe * (2 * lobe - 1)) * (sigma * sigma);
    if (response > best_response) {
      best_response = response;
      best_size = 3 * lobe;
    }
  }
  return best_size;
}

TEST(SurfDetector, FindsGaussianBlobsWhereAndAsLargeAsTheyAre) {
  Random random(7);
  for (double sigma : {2.5, 3.1, 4.0, 5.3, 7.0, 9.5, 13.0, 18.0})
    for (double amplitude : {100., -100.})
      for (int trial = 0; trial < 4; ++trial) {
        const double x = 150 + random.uniform(-1, 1), y = 140 + random.uniform(-1, 1);
        const cv::Mat image = BlobScene{{{x, y, sigma, sigma, 0, amplitude}}}.draw(301, 280);
        const auto keypoints = detect(image, unlimited());
        ASSERT_FALSE(keypoints.empty()) << "sigma " << sigma;
        const cv::KeyPoint& strongest = keypoints.front();
        EXPECT_NEAR(strongest.pt.x, x, 0.15 + 0.02 * sigma) << "sigma " << sigma;
        EXPECT_NEAR(strongest.pt.y, y, 0.15 + 0.02 * sigma) << "sigma " << sigma;
        EXPECT_NEAR(strongest.size / expected_size(sigma), 1, 0.08) << "sigma " << sigma;
        EXPECT_EQ(strongest.class_id, amplitude > 0 ? -1 : 1);
        EXPECT_GE(strongest.octave, 0);
      }
}

TEST(SurfDetector, EqualNeighboursGiveOneKeypoint) {
  // Symmetric about a pixel's corner: four samples tie.
  const cv::Mat image = BlobScene{{{60.5, 60.5, 3, 3, 0, 100}}}.draw(122, 122);
  const auto keypoints = detect(image, unlimited(500));
  ASSERT_EQ(keypoints.size(), 1u);
  EXPECT_NEAR(keypoints[0].pt.x, 60.5, 0.1);
  EXPECT_NEAR(keypoints[0].pt.y, 60.5, 0.1);
}

TEST(SurfDetector, FlatRampAndEmptyImagesHaveNoKeypoints) {
  cv::Mat ramp(200, 200, CV_8UC1);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x) ramp.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(x);
  EXPECT_TRUE(detect(ramp).empty());
  EXPECT_TRUE(detect(cv::Mat(200, 200, CV_8UC1, cv::Scalar(77)), unlimited(0)).empty());
  std::vector<cv::KeyPoint> keypoints(3);
  cv::Mat descriptors(3, 64, CV_32F);
  Surf().detectAndCompute(cv::Mat(), cv::noArray(), keypoints, descriptors);
  EXPECT_TRUE(keypoints.empty());
  EXPECT_TRUE(descriptors.empty());
}

TEST(SurfDetector, AnySizeOfImageIsFine) {
  Surf surf(unlimited(10));
  const cv::Mat large = random_scene(3, 120).draw(240, 240, {1, 0, 120, 120});
  for (int width : {1, 2, 3, 8, 9, 14, 15, 16, 27, 31, 64, 101, 197, 239})
    for (int height : {1, 2, 5, 9, 17, 28, 63, 100, 195}) {
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      surf.detectAndCompute(large(cv::Rect(0, 0, width, height)), cv::noArray(), keypoints, descriptors);
      ASSERT_EQ(descriptors.rows, int(keypoints.size()));
      if (std::min(width, height) < 23) {
        ASSERT_TRUE(keypoints.empty()) << width << "x" << height;
      }
      for (const auto& k : keypoints) {
        // The filter found them, so it lies in the image (but for the interpolated sample).
        ASSERT_GE(k.pt.x, 0);
        ASSERT_GE(k.pt.y, 0);
        ASSERT_LE(k.pt.x, width - 1);
        ASSERT_LE(k.pt.y, height - 1);
        ASSERT_GE(k.response, 0);
      }
    }
}

TEST(SurfDetector, KeypointsOutsideTheMaskAreDropped) {
  const cv::Mat image = random_scene(4, 200).draw(400, 400, {1, 0, 200, 200});
  cv::Mat mask(400, 400, CV_8UC1, cv::Scalar(0));
  mask(cv::Rect(100, 50, 200, 150)).setTo(1);
  const auto all = detect(image, unlimited()), some = detect(image, unlimited(), mask);
  std::size_t expected = 0;
  for (const auto& k : all)
    expected += mask.at<std::uint8_t>(int(std::lround(k.pt.y)), int(std::lround(k.pt.x))) != 0;
  EXPECT_GT(expected, 20u);
  EXPECT_LT(expected, all.size());
  EXPECT_EQ(some.size(), expected);
  for (const auto& k : some)
    EXPECT_TRUE(mask.at<std::uint8_t>(int(std::lround(k.pt.y)), int(std::lround(k.pt.x))));
  EXPECT_TRUE(detect(image, unlimited(), cv::Mat(400, 400, CV_8UC1, cv::Scalar(0))).empty());
}

TEST(SurfDetector, ColourEqualsItsGrey) {
  const cv::Mat grey = random_scene(5, 100).draw(200, 200, {1, 0, 100, 100});
  const auto expected = detect(grey);
  ASSERT_GT(expected.size(), 20u);
  for (int channels : {3, 4}) {
    cv::Mat colour;
    cv::merge(std::vector<cv::Mat>(std::size_t(channels), grey), colour);
    const auto found = detect(colour);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].pt, expected[i].pt);
  }
}

TEST(SurfDetector, WrongInputIsRefusedWithItsReason) {
  const auto message_of = [](auto action) -> std::string {
    try {
      action();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  const cv::Mat grey(50, 60, CV_8UC1, cv::Scalar(0));
  EXPECT_THAT(message_of([] { detect(cv::Mat(50, 50, CV_16UC1, cv::Scalar(0))); }),
              testing::HasSubstr("CV_16UC1"));
  EXPECT_THAT(message_of([] { detect(cv::Mat(50, 50, CV_8UC2, cv::Scalar(0))); }),
              testing::HasSubstr("CV_8UC2"));
  EXPECT_THAT(message_of([&] { detect(grey, {}, cv::Mat(50, 61, CV_8UC1)); }), testing::HasSubstr("61x50"));
  EXPECT_THAT(message_of([&] { detect(grey, {}, cv::Mat(50, 60, CV_32F)); }), testing::HasSubstr("CV_32FC1"));
  const auto with = [&](auto change) {
    SurfSettings settings;
    change(settings);
    return message_of([&] { Surf surf(settings); });
  };
  EXPECT_THAT(with([](auto& s) { s.octaves = 0; }), testing::HasSubstr("octaves is 0"));
  EXPECT_THAT(with([](auto& s) { s.intervals = 2; }), testing::HasSubstr("intervals is 2"));
  EXPECT_THAT(with([](auto& s) { s.hessian_threshold = NAN; }), testing::HasSubstr("hessian_threshold"));
  EXPECT_THAT(with([](auto& s) { s.edge_ratio = 0.5; }), testing::HasSubstr("edge_ratio is 0.5"));
  EXPECT_THAT(with([](auto& s) { s.budget.max_features = -1; }), testing::HasSubstr("max_features is -1"));
  EXPECT_THAT(with([](auto& s) { s.budget.rows = 0; }), testing::HasSubstr("cell_rows is 0"));
  EXPECT_THAT(with([](auto& s) { s.budget.cell_share = 0.5; }), testing::HasSubstr("cell_share"));
  std::vector<cv::KeyPoint> bad{cv::KeyPoint(10, 10, 0)};
  cv::Mat descriptors;
  EXPECT_THAT(message_of([&] { Surf().compute(grey, bad, descriptors); }), testing::HasSubstr("size"));
}

TEST(SurfDetector, TheBudgetTakesTheStrongestAndSpreadsThem) {
  // Strong blobs crowd the left half, weak ones lie on the right.
  BlobScene scene;
  for (int y = 20; y < 300; y += 20)
    for (int x = 20; x < 380; x += 20)
      scene.blobs.push_back({double(x), double(y), 2.5, 2.5, 0, x < 200 ? 100. + (x * 7 + y) % 19 : 45.});
  const cv::Mat image = scene.draw(400, 320);
  const auto all = detect(image, unlimited());
  SurfSettings settings;
  settings.budget.max_features = 100;
  settings.budget.columns = 4;
  settings.budget.rows = 3;
  settings.budget.cell_share = 1;
  const auto spread = detect(image, settings);
  settings.budget.cell_share = 100;
  const auto strongest = detect(image, settings);
  ASSERT_GT(all.size(), 200u);
  ASSERT_EQ(spread.size(), 100u);
  ASSERT_EQ(strongest.size(), 100u);
  const auto on_the_right = [](const auto& keypoints) {
    return std::count_if(keypoints.begin(), keypoints.end(), [](const auto& k) { return k.pt.x >= 200; });
  };
  EXPECT_EQ(on_the_right(strongest), 0);
  EXPECT_GE(on_the_right(spread), 40);
  EXPECT_LE(on_the_right(spread), 60);
  const auto decreasing = [](const auto& a, const auto& b) { return a.response > b.response; };
  EXPECT_TRUE(std::is_sorted(spread.begin(), spread.end(), decreasing));
  for (std::size_t i = 0; i < strongest.size(); ++i) EXPECT_EQ(strongest[i].response, all[i].response);
}

TEST(SurfDetector, BitIdenticalForAnyNumberOfThreadsAndOnReuse) {
  const cv::Mat image = random_scene(6, 250).draw(487, 361, {1, 0, 240, 180});
  const cv::Mat other = random_scene(8, 300).draw(601, 455, {1, 0, 300, 220});
  const int threads_before = cv::getNumThreads();
  std::vector<cv::KeyPoint> reference;
  cv::Mat reference_descriptors;
  Surf reused;
  for (int threads : {1, 2, 3, 8}) {
    cv::setNumThreads(threads);
    Surf fresh;
    for (Surf* surf : {&fresh, &reused}) {
      std::vector<cv::KeyPoint> keypoints;
      cv::Mat descriptors;
      surf->detectAndCompute(other, cv::noArray(), keypoints, descriptors);
      surf->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
      if (reference.empty()) {
        reference = keypoints;
        reference_descriptors = descriptors.clone();
      }
      ASSERT_GT(keypoints.size(), 100u);
      ASSERT_EQ(keypoints.size(), reference.size());
      for (std::size_t i = 0; i < keypoints.size(); ++i) {
        ASSERT_EQ(keypoints[i].pt, reference[i].pt);
        ASSERT_EQ(keypoints[i].size, reference[i].size);
        ASSERT_EQ(keypoints[i].angle, reference[i].angle);
        ASSERT_EQ(keypoints[i].response, reference[i].response);
      }
      ASSERT_EQ(
          std::memcmp(descriptors.data, reference_descriptors.data, descriptors.total() * sizeof(float)), 0);
    }
  }
  cv::setNumThreads(threads_before);
}

TEST(SharedProcessors, EachProcessTakesAQuarterAndAtLeastOne) {
  const int threads_before = cv::getNumThreads();
  cv::setNumThreads(cv::getNumberOfCPUs());
  share_processors();
  EXPECT_EQ(cv::getNumThreads(), std::max(1, cv::getNumberOfCPUs() / 4));
  cv::setNumThreads(threads_before);
}

}  // namespace
}  // namespace lcmslam
