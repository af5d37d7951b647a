#pragma once
// SURF descriptors as their definition says it, one wavelet after the other: what the fast ones must equal.

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/surf/descriptor.hpp>

namespace lcmslam::test {

using Vector = std::vector<double>;

inline double cosine(const Vector& a, const float* b) {
  double dot = 0;
  for (std::size_t k = 0; k < a.size(); ++k) dot += a[k] * double(b[k]);
  return dot;
}

inline double normalise(Vector& v) {
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
inline Vector sums_of_regions(const Wavelets& w, bool extended, Vector* slack = nullptr) {
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
inline double box_mean(const cv::Mat& image, int x, int y, int side, int block) {
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
inline double mean_between(const cv::Mat& image, double px, double py, int side, int block) {
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

inline Vector plain_descriptor(const cv::Mat& image, double x, double y, double s, double angle,
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
inline Vector ideal_descriptor(const cv::Mat_<double>& exact, double x, double y, double s, double angle) {
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

}  // namespace lcmslam::test
