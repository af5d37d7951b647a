#include "surf/descriptor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lcmslam {
namespace {

constexpr float pi = 3.14159265358979f;

// -- orientation: a patch of means at half-integer multiples of s; a wavelet of 4 s is 4 x 4 of them.
constexpr int radius = 6;
constexpr int wavelets = 2 * radius + 1;
constexpr int means = wavelets + 3;
constexpr int bins = 72;
constexpr int window = bins / 6;

std::array<float, wavelets * wavelets> disc_weights() {
  std::array<float, wavelets * wavelets> weights{};
  for (int j = -radius; j <= radius; ++j)
    for (int i = -radius; i <= radius; ++i)
      if (i * i + j * j <= radius * radius)
        weights[static_cast<std::size_t>((j + radius) * wavelets + i + radius)] =
            static_cast<float>(std::exp(-(i * i + j * j) / (2. * 2. * 2.)));
  return weights;
}

// Polynomial arc tangent, in turns [0, 1): good to 0.001 degrees, where a bin has 5. One formula without
// branches, so that a loop over it vectorises and gives the same bits everywhere.
float turns(float x, float y) {
  const float absolute_x = std::abs(x), absolute_y = std::abs(y);
  const float longer = std::max(absolute_x, absolute_y), shorter = std::min(absolute_x, absolute_y);
  const float t = shorter / std::max(longer, 1e-20f), t2 = t * t;
  float angle =
      t * (0.15913367f + t2 * (-0.05256963f + t2 * (0.02867320f + t2 * (-0.01355300f + t2 * 0.00331758f))));
  angle = absolute_y > absolute_x ? 0.25f - angle : angle;
  angle = x < 0 ? 0.5f - angle : angle;
  return y < 0 ? 1.f - angle : angle;
}

// -- descriptor: a patch of means at multiples of s; a wavelet of 2 s is 2 x 2 of them.
constexpr int samples = 20;
constexpr int corners = samples + 1;
constexpr int regions = 4;
constexpr int region_samples = samples / regions;

std::array<float, samples * samples> window_weights() {
  std::array<float, samples * samples> weights{};
  for (int j = 0; j < samples; ++j)
    for (int i = 0; i < samples; ++i) {
      const double u = i - 0.5 * (samples - 1), v = j - 0.5 * (samples - 1);
      weights[static_cast<std::size_t>(j * samples + i)] =
          static_cast<float>(std::exp(-(u * u + v * v) / (2. * 3.3 * 3.3)));
    }
  return weights;
}

}  // namespace

float dominant_orientation(const PatchSampler& sampler, float x, float y, float scale) {
  static const auto weights = disc_weights();
  float patch[means * means];
  sampler.sample({x, y, 1.f, 0.f, scale}, means, patch);

  float dx[wavelets * wavelets], dy[wavelets * wavelets], angle[wavelets * wavelets];
  for (int j = 0; j < wavelets; ++j) {
    float column_sum[means], column_difference[means];
    const float* row = patch + j * means;
    for (int i = 0; i < means; ++i) {
      const float upper = row[i] + row[i + means], lower = row[i + 2 * means] + row[i + 3 * means];
      column_sum[i] = upper + lower;
      column_difference[i] = lower - upper;
    }
    for (int i = 0; i < wavelets; ++i) {
      const float weight = weights[static_cast<std::size_t>(j * wavelets + i)];
      dx[j * wavelets + i] =
          weight * ((column_sum[i + 2] + column_sum[i + 3]) - (column_sum[i] + column_sum[i + 1]));
      dy[j * wavelets + i] = weight * ((column_difference[i] + column_difference[i + 1]) +
                                       (column_difference[i + 2] + column_difference[i + 3]));
    }
  }
  for (int k = 0; k < wavelets * wavelets; ++k) angle[k] = turns(dx[k], dy[k]);

  float bin_x[bins] = {}, bin_y[bins] = {};
  for (int k = 0; k < wavelets * wavelets; ++k) {
    const int bin = std::min(static_cast<int>(angle[k] * bins), bins - 1);
    bin_x[bin] += dx[k];
    bin_y[bin] += dy[k];
  }
  float best_length2 = 0, best_x = 0, best_y = 0;
  for (int start = 0; start < bins; ++start) {
    float sum_x = 0, sum_y = 0;
    for (int k = start; k < start + window; ++k) {
      sum_x += bin_x[k % bins];
      sum_y += bin_y[k % bins];
    }
    const float length2 = sum_x * sum_x + sum_y * sum_y;
    if (length2 > best_length2) {
      best_length2 = length2;
      best_x = sum_x;
      best_y = sum_y;
    }
  }
  if (best_length2 == 0) return 0;
  const float direction = std::atan2(best_y, best_x);
  return direction < 0 ? std::min(direction + 2 * pi, 2 * pi) : direction;
}

void describe(const PatchSampler& sampler, float x, float y, float scale, float angle, float* descriptor) {
  static const auto weights = window_weights();
  float patch[corners * corners];
  sampler.sample({x, y, std::cos(angle), std::sin(angle), scale}, corners, patch);

  for (int region_row = 0; region_row < regions; ++region_row) {
    // Sums down the region's rows first: loops over the contiguous columns vectorise.
    float sum_dx[samples] = {}, sum_dy[samples] = {}, sum_abs_dx[samples] = {}, sum_abs_dy[samples] = {};
    for (int j = region_row * region_samples; j < (region_row + 1) * region_samples; ++j) {
      const float* upper = patch + j * corners;
      const float* lower = upper + corners;
      const float* weight = weights.data() + j * samples;
      for (int i = 0; i < samples; ++i) {
        const float rising = lower[i + 1] - upper[i], falling = upper[i + 1] - lower[i];
        const float dx = weight[i] * (rising + falling), dy = weight[i] * (rising - falling);
        sum_dx[i] += dx;
        sum_dy[i] += dy;
        sum_abs_dx[i] += std::abs(dx);
        sum_abs_dy[i] += std::abs(dy);
      }
    }
    for (int region_column = 0; region_column < regions; ++region_column) {
      float* out = descriptor + 4 * (region_row * regions + region_column);
      std::fill(out, out + 4, 0.f);
      for (int i = region_column * region_samples; i < (region_column + 1) * region_samples; ++i) {
        out[0] += sum_dx[i];
        out[1] += sum_dy[i];
        out[2] += sum_abs_dx[i];
        out[3] += sum_abs_dy[i];
      }
    }
  }
  float norm2 = 0;
  for (int k = 0; k < 64; ++k) norm2 += descriptor[k] * descriptor[k];
  // Means of 8-bit grey values: below this the patch is flat and the sums are rounding.
  const float factor = norm2 > 1e-4f ? 1.f / std::sqrt(norm2) : 0.f;
  for (int k = 0; k < 64; ++k) descriptor[k] *= factor;
}

}  // namespace lcmslam
