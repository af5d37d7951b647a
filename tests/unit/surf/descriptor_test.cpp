#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "blob_scene.hpp"
#include "surf/descriptor.hpp"
#include "surf/surf.hpp"

namespace lcmslam {
namespace {

using test::BlobScene;
using test::random_scene;
using test::Similarity;
using Vector = std::vector<double>;

double cosine(const Vector& a, const float* b) {
  double dot = 0;
  for (std::size_t k = 0; k < a.size(); ++k) dot += a[k] * double(b[k]);
  return dot;
}

double normalise(Vector& v) {
  double norm2 = 0;
  for (double c : v) norm2 += c * c;
  for (double& c : v) c /= std::sqrt(norm2);
  return 1 / std::sqrt(norm2);
}

constexpr double pitch = 4. / 3;  // of the patch, in units of s

// Haar responses of the 15 x 15 wavelets, dx[j][i] at pitch * (i - 7, j - 7) s from the centre.
struct Wavelets {
  double dx[15][15], dy[15][15];
};

// A derivative so near 0 that rounding decides its sign, and with it where SURF-128 adds the other.
constexpr double undecided = 0.01;  // grey values

// Sums over the overlapping regions as their definition says it, one wavelet after the other.
// `slack` gets how far each may be off by undecided signs.
Vector sums_of_regions(const Wavelets& w, bool extended, Vector* slack = nullptr) {
  const auto gauss = [](double d, double sigma) { return std::exp(-d * d / (2 * sigma * sigma)); };
  Vector descriptor;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      const double of_region = gauss(row - 1.5, 1.5) * gauss(column - 1.5, 1.5);
      double all[4] = {}, split[8] = {}, either[2] = {};
      for (int j = 0; j < 6; ++j)
        for (int i = 0; i < 6; ++i) {
          const double weight = of_region * gauss(i - 2.5, 1.7) * gauss(j - 2.5, 1.7);
          const double dx = weight * w.dx[3 * row + j][3 * column + i];
          const double dy = weight * w.dy[3 * row + j][3 * column + i];
          all[0] += dx;
          all[1] += dy;
          all[2] += std::abs(dx);
          all[3] += std::abs(dy);
          either[0] += std::abs(w.dy[3 * row + j][3 * column + i]) < undecided ? std::abs(dx) : 0;
          either[1] += std::abs(w.dx[3 * row + j][3 * column + i]) < undecided ? std::abs(dy) : 0;
          split[dy < 0 ? 2 : 0] += dx;
          split[dy < 0 ? 3 : 1] += std::abs(dx);
          split[dx < 0 ? 6 : 4] += dy;
          split[dx < 0 ? 7 : 5] += std::abs(dy);
        }
      if (extended)
        descriptor.insert(descriptor.end(), split, split + 8);
      else
        descriptor.insert(descriptor.end(), all, all + 4);
      if (extended && slack)
        for (const double sum : either) slack->insert(slack->end(), 4, sum);
    }
  const double factor = normalise(descriptor);
  if (slack)
    for (double& s : *slack) s *= factor;
  return descriptor;
}

// Mean of the side x side blocks of `block` x `block` pixels around a block, cut to the whole blocks.
double box_mean(const cv::Mat& image, int x, int y, int side, int block) {
  double sum = 0;
  int count = 0;
  for (int row = (y - side / 2) * block; row < (y - side / 2 + side) * block; ++row)
    for (int column = (x - side / 2) * block; column < (x - side / 2 + side) * block; ++column)
      if (row >= 0 && column >= 0 && row < image.rows / block * block &&
          column < image.cols / block * block) {
        sum += image.at<std::uint8_t>(row, column);
        ++count;
      }
  return sum / count;
}

// Box means between blocks, in double precision and straight from the pixels.
double mean_between(const cv::Mat& image, double px, double py, int side, int block) {
  const int columns = image.cols / block, rows = image.rows / block;
  const double shift = side % 2 ? 0 : 0.5;
  const double x = std::clamp((px + 0.5) / block - 0.5 + shift, 0., columns - 1.);
  const double y = std::clamp((py + 0.5) / block - 0.5 + shift, 0., rows - 1.);
  const int column = int(x), row = int(y), right = std::min(column + 1, columns - 1),
            below = std::min(row + 1, rows - 1);
  const double a = x - column, b = y - row;
  const auto mean = [&](int c, int r) { return box_mean(image, c, r, side, block); };
  return (1 - b) * ((1 - a) * mean(column, row) + a * mean(right, row)) +
         b * ((1 - a) * mean(column, below) + a * mean(right, below));
}

Vector plain_descriptor(const cv::Mat& image, double x, double y, double s, double angle,
                        bool extended = false, Vector* slack = nullptr) {
  const double c = std::cos(angle) * pitch * s, n = std::sin(angle) * pitch * s;
  double width = 1.35 * pitch * s;
  int block = 1;
  for (; width >= 5.5; width /= 2) block *= 2;
  const int side = std::max(1, int(std::lround(width)));
  double at[16][16];
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 16; ++i) {
      const double u = i - 7.5, v = j - 7.5;
      at[j][i] = mean_between(image, x + c * u - n * v, y + n * u + c * v, side, block);
    }
  Wavelets w;
  for (int j = 0; j < 15; ++j)
    for (int i = 0; i < 15; ++i) {
      const double p = at[j][i], q = at[j][i + 1], r = at[j + 1][i], t = at[j + 1][i + 1];
      w.dx[j][i] = q + t - p - r;
      w.dy[j][i] = r + t - p - q;
    }
  return sums_of_regions(w, extended, slack);
}

// The definition itself: Haar wavelets of side 8/3 s turned with the blob, integrated over the exact
// scene.
Vector ideal_descriptor(const cv::Mat_<double>& exact, double x, double y, double s, double angle) {
  const double c = std::cos(angle) * pitch * s, n = std::sin(angle) * pitch * s;
  constexpr int fine = 8;  // integration points a wavelet's half
  const auto at = [&](double u, double v) {
    const double px = x + c * u - n * v, py = y + n * u + c * v;
    const int column = int(std::floor(px)), row = int(std::floor(py));
    const double a = px - column, b = py - row;
    return (1 - b) * ((1 - a) * exact(row, column) + a * exact(row, column + 1)) +
           b * ((1 - a) * exact(row + 1, column) + a * exact(row + 1, column + 1));
  };
  Wavelets w{};
  for (int j = 0; j < 15; ++j)
    for (int i = 0; i < 15; ++i)
      for (int q = -fine; q < fine; ++q)
        for (int p = -fine; p < fine; ++p) {
          const double value = at(i - 7 + (p + 0.5) / fine, j - 7 + (q + 0.5) / fine);
          w.dx[j][i] += p < 0 ? -value : value;
          w.dy[j][i] += q < 0 ? -value : value;
        }
  return sums_of_regions(w, false);
}

struct Features {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;

  explicit Features(const cv::Mat& image, SurfSettings settings = {}) {
    Surf(settings).detectAndCompute(image, cv::noArray(), keypoints, descriptors);
  }
};

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
