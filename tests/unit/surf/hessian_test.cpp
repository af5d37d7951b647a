#include <gtest/gtest.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/surf/hessian.hpp>

namespace lcmslam {
namespace {

cv::Mat noise_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random.below(256));
  return image;
}

// The filters of the paper's figure 2, drawn pixel by pixel around their centre.
struct Weights {
  int xx, yy, xy;
};

Weights weights_at(int lobe, int x, int y) {
  const auto stripe = [&](int along, int across) {
    if (std::abs(across) > lobe - 1) return 0;
    if (std::abs(along) <= (lobe - 1) / 2) return -2;
    return std::abs(along) <= (3 * lobe - 1) / 2 ? 1 : 0;
  };
  const bool in_square = x != 0 && y != 0 && std::abs(x) <= lobe && std::abs(y) <= lobe;
  return {stripe(x, y), stripe(y, x), in_square ? ((x < 0) == (y < 0) ? 1 : -1) : 0};
}

BoxHessian summed_directly(const cv::Mat& image, int lobe, int x, int y) {
  const int half = (3 * lobe - 1) / 2;
  BoxHessian sums;
  for (int dy = -half; dy <= half; ++dy)
    for (int dx = -half; dx <= half; ++dx) {
      const Weights w = weights_at(lobe, dx, dy);
      const int value = image.at<std::uint8_t>(y + dy, x + dx);
      sums.xx += w.xx * value;
      sums.yy += w.yy * value;
      sums.xy += w.xy * value;
    }
  return sums;
}

double determinant(const BoxHessian& sums, int lobe) {
  const double area = lobe * (2. * lobe - 1), weight2 = (2. * lobe - 1) / (2. * lobe);
  return (double(sums.xx) * sums.yy - weight2 * double(sums.xy) * sums.xy) / (area * area);
}

TEST(IntegralImage, BoxesAreSums) {
  const cv::Mat image = noise_image(37, 23, 1);
  IntegralImage integral;
  integral.compute(image);
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const int x0 = int(random.below(38)), y0 = int(random.below(24));
    const int x1 = x0 + int(random.below(std::uint64_t(38 - x0))),
              y1 = y0 + int(random.below(std::uint64_t(24 - y0)));
    int sum = 0;
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) sum += image.at<std::uint8_t>(y, x);
    ASSERT_EQ(integral.box(x0, y0, x1, y1), sum) << x0 << " " << y0 << " " << x1 << " " << y1;
  }
}

TEST(IntegralImage, BoxesStayRightWhenTheWholeSumOverflows) {
  const cv::Mat white(4200, 4200, CV_8UC1, cv::Scalar(255));  // 4.5e9 > 2^32
  IntegralImage integral;
  integral.compute(white);
  EXPECT_EQ(integral.box(4100, 4000, 4200, 4200), 100 * 200 * 255);
  EXPECT_EQ(integral.box(0, 4199, 4200, 4200), 4200 * 255);
}

TEST(IntegralImage, HalvedIsOfSumsOfFourPixels) {
  const cv::Mat image = noise_image(41, 31, 6);
  IntegralImage fine, halved;
  fine.compute(image);
  halved.halve(fine);
  ASSERT_EQ(halved.width(), 20);
  ASSERT_EQ(halved.height(), 15);
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 20; ++x)
      ASSERT_EQ(halved.box(x, y, x + 1, y + 1), cv::sum(image(cv::Rect(2 * x, 2 * y, 2, 2)))[0]);
}

TEST(IntegralImage, ReadsViewsWithGapsBetweenRows) {
  const cv::Mat image = noise_image(40, 30, 3);
  const cv::Mat view = image(cv::Rect(5, 4, 20, 10));
  IntegralImage of_view, of_copy;
  of_view.compute(view);
  of_copy.compute(view.clone());
  for (int y = 0; y <= 10; ++y)
    for (int x = 0; x <= 20; ++x) ASSERT_EQ(of_view.row(y)[x], of_copy.row(y)[x]);
}

TEST(BoxHessian, EqualsDirectSummation) {
  const cv::Mat image = noise_image(70, 61, 4);
  IntegralImage integral;
  integral.compute(image);
  for (int lobe : {3, 5, 7, 9, 13, 17}) {
    const int half = (3 * lobe - 1) / 2;
    for (int y = half; y < 61 - half; y += 3)
      for (int x = half; x < 70 - half; x += 3) {
        const BoxHessian fast = box_hessian(integral, lobe, x, y),
                         direct = summed_directly(image, lobe, x, y);
        ASSERT_EQ(fast.xx, direct.xx) << "lobe " << lobe << " at " << x << " " << y;
        ASSERT_EQ(fast.yy, direct.yy) << "lobe " << lobe << " at " << x << " " << y;
        ASSERT_EQ(fast.xy, direct.xy) << "lobe " << lobe << " at " << x << " " << y;
      }
  }
}

TEST(HessianPyramid, EveryLayerEqualsDirectSummation) {
  for (const cv::Size size : {cv::Size(131, 117), cv::Size(128, 96)}) {
    const cv::Mat image = noise_image(size.width, size.height, 5);
    IntegralImage integral;
    integral.compute(image);
    HessianPyramid pyramid;
    pyramid.compute(integral, 3, 4);
    ASSERT_EQ(pyramid.octaves(), 3);
    for (int o = 0; o < 3; ++o)
      for (int i = 0; i < 4; ++i) {
        const HessianLayer& layer = pyramid.layer(o, i);
        const int half = (3 * layer.lobe - 1) / 2;
        ASSERT_EQ(layer.lobe, (2 << o) * (i + 1) + 1);
        ASSERT_EQ(layer.step, o == 0 ? 1 : 1 << (o - 1));
        // The stated samples are exactly those whose filter lies in the image.
        for (int r = 0; r < layer.rows; ++r)
          for (int c = 0; c < layer.columns; ++c) {
            const int x = c * layer.step, y = r * layer.step;
            const bool fits = x >= half && y >= half && x + half < size.width && y + half < size.height;
            const bool stated = r >= layer.first_row && r <= layer.last_row && c >= layer.first_column &&
                                c <= layer.last_column;
            ASSERT_EQ(fits, stated) << "layer " << layer.lobe << " at " << x << " " << y;
            if (!fits || (x + y) % 5 != 0) continue;
            const double expected = determinant(summed_directly(image, layer.lobe, x, y), layer.lobe);
            ASSERT_NEAR(layer.row(r)[c], expected, 1e-3 + 1e-5 * std::abs(expected));
          }
      }
  }
}

// Stripes as wide as a lobe are what its filter answers most to: the largest sums that there are.
TEST(HessianPyramid, BlackAndWhiteStripesOverflowNothing) {
  for (const int width : {3, 5, 7, 9})
    for (const bool upright : {false, true}) {
      cv::Mat image(60, 70, CV_8UC1);
      for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
          image.at<std::uint8_t>(y, x) = (upright ? x : y) / width % 2 != 0 ? 255 : 0;
      IntegralImage integral;
      integral.compute(image);
      HessianPyramid pyramid;
      pyramid.compute(integral, 1, 4);
      int largest = 0;
      for (int i = 0; i < 4; ++i) {
        const HessianLayer& layer = pyramid.layer(0, i);
        for (int r = layer.first_row; r <= layer.last_row; ++r)
          for (int c = layer.first_column; c <= layer.last_column; ++c) {
            const BoxHessian sums = box_hessian(integral, layer.lobe, c, r);
            const double expected = determinant(sums, layer.lobe);
            ASSERT_NEAR(layer.row(r)[c], expected, 1e-3 + 1e-5 * std::abs(expected)) << layer.lobe;
            if (layer.lobe == width) largest = std::max({largest, std::abs(sums.xx), std::abs(sums.yy)});
          }
      }
      EXPECT_EQ(largest, 255 * 2 * width * (2 * width - 1));
    }
}

// On a quadratic surface the box filters are exact multiples of the second derivatives: lobe^2 for the
// stripes' mean and (lobe + 1)^2 for the squares' mean.
TEST(BoxHessian, MeasuresSecondDerivatives) {
  const int size = 61, centre = 30;
  const auto image_of = [&](auto f) {
    cv::Mat image(size, size, CV_8UC1);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(f(x - centre, y - centre));
    return image;
  };
  for (int lobe : {3, 5, 7}) {
    IntegralImage integral;
    integral.compute(image_of([](int x, int) { return std::min(255, x * x); }));
    // Dxx of x^2 is 2, within 15 pixels of the centre where nothing is cut off.
    BoxHessian sums = box_hessian(integral, lobe, centre, centre);
    EXPECT_EQ(sums.xx, 2 * lobe * lobe * lobe * (2 * lobe - 1));
    EXPECT_EQ(sums.xy, 0);
    integral.compute(image_of([](int x, int y) { return std::clamp(128 + x * y, 0, 255); }));
    sums = box_hessian(integral, lobe, centre, centre);
    EXPECT_EQ(sums.xx, 0);
    EXPECT_EQ(sums.yy, 0);
    EXPECT_EQ(sums.xy, (lobe + 1) * (lobe + 1) * lobe * lobe);
  }
}

}  // namespace
}  // namespace lcmslam
