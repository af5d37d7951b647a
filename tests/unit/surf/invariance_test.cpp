// Orientation, and what becomes of keypoints when the image turns, grows, brightens or is inverted.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"
#include "tests/unit/surf/detected_features.hpp"

namespace lcmslam {
namespace {

using test::BlobScene;
using test::Features;
using test::random_scene;
using test::Similarity;

double angle_difference(double a, double b) {
  const double d = std::fmod(std::abs(a - b), 360.);
  return std::min(d, 360 - d);
}

TEST(SurfOrientation, PointsAcrossAnEdgeToItsBrightSide) {
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double angle = degrees * M_PI / 180;
    cv::Mat image(121, 121, CV_8UC1);
    for (int y = 0; y < 121; ++y)
      for (int x = 0; x < 121; ++x) {
        const double along = std::cos(angle) * (x - 60) + std::sin(angle) * (y - 60);
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(128 + std::clamp(along * 10, -100., 100.));
      }
    for (float size : {15.f, 21.f, 40.f, 60.f}) {
      std::vector<cv::KeyPoint> keypoint{cv::KeyPoint(60, 60, size)};
      cv::Mat descriptor;
      Surf().compute(image, keypoint, descriptor);
      EXPECT_LT(angle_difference(keypoint[0].angle, degrees), 1.5) << degrees << " degrees, size " << size;
      // In the blob's own frame the edge always looks the same: all gradients along dx.
      for (int region = 0; region < 16; ++region)
        EXPECT_GE(descriptor.at<float>(0, 4 * region), -1e-3) << degrees << " degrees, size " << size;
    }
  }
}

// A bright blob with a dark companion: the orientation turns with the pattern.
TEST(SurfOrientation, FollowsAnAsymmetricPattern) {
  BlobScene scene;
  scene.blobs = {{0, 0, 5, 5, 0, 80}, {9, 0, 3, 3, 0, -60}};
  double reference = 0;
  for (int degrees = 0; degrees < 360; degrees += 15) {
    const cv::Mat image = scene.draw(201, 201, {1, degrees * M_PI / 180, 100, 100});
    const Features features(image);
    ASSERT_FALSE(features.keypoints.empty());
    const auto main =
        std::min_element(features.keypoints.begin(), features.keypoints.end(), [](auto& a, auto& b) {
          return cv::norm(a.pt - cv::Point2f(100, 100)) + (a.class_id > 0 ? 1e3 : 0) <
                 cv::norm(b.pt - cv::Point2f(100, 100)) + (b.class_id > 0 ? 1e3 : 0);
        });
    if (degrees == 0) reference = main->angle;
    EXPECT_LT(angle_difference(main->angle, reference + degrees), 10) << degrees;
  }
}

// Of the keypoints of one image that the other also shows: how many are found again in place, size and
// angle, and how many of those have their nearest descriptor there.
struct Invariance {
  double repeated = 0, turned_alike = 0, matched = 0;
};

Invariance compare(const Features& a, const Features& b, const Similarity& b_from_a, int width, int height) {
  int visible = 0, repeated = 0, turned = 0, matched = 0;
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    const cv::KeyPoint& p = a.keypoints[i];
    const cv::Point2f place(b_from_a(p.pt.x, p.pt.y));
    const double size = p.size * b_from_a.scale, border = size;
    if (size < 15 || place.x < border || place.y < border || place.x > width - border ||
        place.y > height - border)
      continue;
    ++visible;
    const auto is_same = [&](const cv::KeyPoint& q) {
      return cv::norm(q.pt - place) < 0.1 * size && std::abs(std::log(q.size / size)) < std::log(1.3) &&
             q.class_id == p.class_id;
    };
    std::size_t nearest = 0;
    double least = 1e9;
    bool found = false, same_angle = false;
    for (std::size_t j = 0; j < b.keypoints.size(); ++j) {
      const double distance = cv::norm(a.descriptors.row(int(i)), b.descriptors.row(int(j)));
      if (distance < least) {
        least = distance;
        nearest = j;
      }
      if (!is_same(b.keypoints[j])) continue;
      found = true;
      same_angle |= angle_difference(b.keypoints[j].angle, p.angle + b_from_a.angle * 180 / M_PI) < 15;
    }
    repeated += found;
    turned += found && same_angle;
    matched += found && is_same(b.keypoints[nearest]);
  }
  EXPECT_GT(visible, 60);
  return {double(repeated) / visible, double(turned) / repeated, double(matched) / repeated};
}

SurfSettings all_strong() {
  SurfSettings settings;
  settings.budget.max_features = 0;
  return settings;
}

// Round blobs have no strong direction of their own: with them orientation is at its hardest.
TEST(SurfInvariance, RotationAndScale) {
  const BlobScene scene = random_scene(16, 400, 1200);
  const Similarity first{1, 0, 200, 200};
  SurfSettings weaker = all_strong();
  weaker.hessian_threshold = 25;  // so that what was just above the threshold is not lost below it
  const Features reference(scene.draw(400, 400, first), all_strong());
  for (double degrees : {0., 10., 30., 45., 90., 137., 180., 270.})
    for (double scale : {1., 1.25, 1.6, 2.}) {
      const Similarity second{scale, degrees * M_PI / 180, 300, 300};
      // b_from_a = second * first^-1
      Similarity b_from_a{scale, second.angle, 0, 0};
      const cv::Point2d moved = b_from_a(-200, -200);
      b_from_a.x = moved.x + 300;
      b_from_a.y = moved.y + 300;
      const Features turned(scene.draw(600, 600, second), weaker);
      const Invariance result = compare(reference, turned, b_from_a, 600, 600);
      EXPECT_GT(result.repeated, 0.85) << degrees << " degrees, scale " << scale;
      EXPECT_GT(result.turned_alike, 0.65) << degrees << " degrees, scale " << scale;
      EXPECT_GT(result.matched, 0.77) << degrees << " degrees, scale " << scale;
    }
}

TEST(SurfInvariance, BrightnessContrastAndInversion) {
  const BlobScene scene = random_scene(17, 200, 350);
  const Similarity centre{1, 0, 200, 200};
  const Features reference(scene.draw(400, 400, centre, 0.6, 40), all_strong());
  SurfSettings weaker = all_strong();
  weaker.hessian_threshold = 10;
  for (auto [gain, offset] : {std::pair{0.6, 20.}, {0.6, 70.}, {0.35, 60.}, {0.25, 100.}}) {
    const Features changed(scene.draw(400, 400, centre, gain, offset), weaker);
    const Invariance result = compare(reference, changed, {}, 400, 400);
    EXPECT_GT(result.repeated, 0.9) << gain << " * grey + " << offset;
    EXPECT_GT(result.turned_alike, 0.93) << gain << " * grey + " << offset;
    EXPECT_GT(result.matched, 0.95) << gain << " * grey + " << offset;
  }
  // Inverted: the same places, opposite signs.
  const Features inverted(scene.draw(400, 400, centre, -0.6, 215), all_strong());
  ASSERT_NEAR(double(inverted.keypoints.size()), double(reference.keypoints.size()),
              0.03 * double(reference.keypoints.size()));
  int same_place = 0;
  for (const auto& p : reference.keypoints)
    same_place += std::any_of(inverted.keypoints.begin(), inverted.keypoints.end(), [&](const auto& q) {
      return cv::norm(p.pt - q.pt) < 0.5 && p.class_id == -q.class_id;
    });
  EXPECT_GT(same_place, 0.95 * double(reference.keypoints.size()));
}

}  // namespace
}  // namespace lcmslam
