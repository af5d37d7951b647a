#include <lcmslam/surf/descriptor.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr float pi = 3.14159265358979f;

// -- orientation: a wavelet is 2 x 2 means of the patch.
constexpr int radius = 4;
constexpr int wavelets = 2 * radius + 1;
constexpr int means = wavelets + 1;
constexpr int in_disc = 49;  // whole points within 4 of a point
constexpr int bins = 72;
constexpr int window = 22;  // bins

struct Disc {
  std::array<float, wavelets * wavelets> weights{};
  std::array<int, in_disc> inside{};  // indices

  Disc() {
    std::size_t count = 0;
    for (int j = -radius; j <= radius; ++j)
      for (int i = -radius; i <= radius; ++i) {
        if (i * i + j * j > radius * radius) continue;
        const int k = (j + radius) * wavelets + i + radius;
        constexpr double sigma = 2 / static_cast<double>(patch_pitch);
        weights[static_cast<std::size_t>(k)] =
            static_cast<float>(std::exp(-(i * i + j * j) / (2 * sigma * sigma)));
        inside.at(count++) = k;
      }
  }
};

LCMSLAM_VECTORISED(weighted_wavelets,
                   (const float* patch, const float* weights, float* __restrict dx, float* __restrict dy),
                   (patch, weights, dx, dy)) {
  for (int j = 0; j < wavelets; ++j) {
    const float *upper = patch + j * means, *lower = upper + means;
    for (int i = 0; i < wavelets; ++i) {
      const int k = j * wavelets + i;
      const float rising = lower[i + 1] - upper[i], falling = upper[i + 1] - lower[i];
      dx[k] = weights[k] * (rising + falling);
      dy[k] = weights[k] * (rising - falling);
    }
  }
}

// Directions in turns [0, 1): a polynomial arc tangent, good to 0.001 degrees, where a bin has 5. One
// formula without branches, so that the loop vectorises and gives the same bits everywhere.
LCMSLAM_VECTORISED(turns, (const float* dx, const float* dy, int n, float* __restrict angle),
                   (dx, dy, n, angle)) {
  for (int k = 0; k < n; ++k) {
    const float x = dx[k], y = dy[k];
    const float absolute_x = x < 0 ? -x : x, absolute_y = y < 0 ? -y : y;
    const float longer = absolute_x > absolute_y ? absolute_x : absolute_y;
    const float shorter = absolute_x > absolute_y ? absolute_y : absolute_x;
    const float t = shorter / (longer > 1e-20f ? longer : 1e-20f), t2 = t * t;
    const float octant =
        t * (0.15913367f + t2 * (-0.05256963f + t2 * (0.02867320f + t2 * (-0.01355300f + t2 * 0.00331758f))));
    const float quadrant = absolute_y > absolute_x ? 0.25f - octant : octant;
    const float half = x < 0 ? 0.5f - quadrant : quadrant;
    angle[k] = y < 0 ? 1.f - half : half;
  }
}

// -- descriptor: a wavelet is 2 x 2 means of the patch.
constexpr int corners = 16;
constexpr int samples = corners - 1;
constexpr int regions = 4;
constexpr int region_samples = 6;
constexpr int region_step = 3;
static_assert(region_step * (regions - 1) + region_samples == samples);

template <std::size_t N>
std::array<float, N> gaussian(double sigma) {
  std::array<float, N> weights{};
  for (std::size_t i = 0; i < N; ++i) {
    const double u = static_cast<double>(i) - 0.5 * static_cast<double>(N - 1);
    weights[i] = static_cast<float>(std::exp(-u * u / (2 * sigma * sigma)));
  }
  return weights;
}

struct Weights {
  std::array<float, region_samples> sample = gaussian<region_samples>(1.7);
  std::array<float, regions> region = gaussian<regions>(1.5);
};

// Sums[kind][region row][column]: down the rows of a region row. Kinds in the descriptor's order.
template <int Kinds>
using RowSums = float[Kinds][regions][corners];

template <int Kinds>
__attribute__((always_inline)) inline void sum_rows_loop(const float* patch, const float* weight,
                                                         RowSums<Kinds>& sums) {
  float dx[samples][corners], dy[samples][corners];
  for (int j = 0; j < samples; ++j) {
    const float *upper = patch + j * corners, *lower = upper + corners;
    for (int i = 0; i < samples; ++i) {
      const float rising = lower[i + 1] - upper[i], falling = upper[i + 1] - lower[i];
      dx[j][i] = rising + falling;
      dy[j][i] = rising - falling;
    }
    dx[j][samples] = dy[j][samples] = 0;
  }
  for (int region = 0; region < regions; ++region)
    for (int i = 0; i < corners; ++i) {
      float sum[Kinds] = {};
      for (int j = 0; j < region_samples; ++j) {
        const float x = weight[j] * dx[region * region_step + j][i];
        const float y = weight[j] * dy[region * region_step + j][i];
        const float absolute_x = x < 0 ? -x : x, absolute_y = y < 0 ? -y : y;
        if (Kinds == 4) {
          sum[0] += x;
          sum[1] += y;
          sum[2] += absolute_x;
          sum[3] += absolute_y;
        } else {
          sum[0] += y < 0 ? 0 : x;
          sum[1] += y < 0 ? 0 : absolute_x;
          sum[2 % Kinds] += y < 0 ? x : 0;
          sum[3 % Kinds] += y < 0 ? absolute_x : 0;
          sum[4 % Kinds] += x < 0 ? 0 : y;
          sum[5 % Kinds] += x < 0 ? 0 : absolute_y;
          sum[6 % Kinds] += x < 0 ? y : 0;
          sum[7 % Kinds] += x < 0 ? absolute_y : 0;
        }
      }
      for (int kind = 0; kind < Kinds; ++kind) sums[kind][region][i] = sum[kind];
    }
}

LCMSLAM_VECTORISED(sum_rows_64, (const float* patch, const float* weight, RowSums<4>& sums),
                   (patch, weight, sums)) {
  sum_rows_loop<4>(patch, weight, sums);
}

LCMSLAM_VECTORISED(sum_rows_128, (const float* patch, const float* weight, RowSums<8>& sums),
                   (patch, weight, sums)) {
  sum_rows_loop<8>(patch, weight, sums);
}

template <int Kinds, typename SumRows>
void describe_regions(const PatchSampler& sampler, const PatchPose& pose, SumRows sum_rows,
                      float* descriptor) {
  static const Weights weights;
  float patch[corners * corners + 7];
  sampler.sample(pose, corners, patch);
  RowSums<Kinds> sums;
  sum_rows(patch, weights.sample.data(), sums);

  float* out = descriptor;
  float norm2 = 0;
  for (int row = 0; row < regions; ++row)
    for (int column = 0; column < regions; ++column) {
      const float weight =
          weights.region[static_cast<std::size_t>(row)] * weights.region[static_cast<std::size_t>(column)];
      for (int kind = 0; kind < Kinds; ++kind) {
        const float* values = sums[kind][row] + column * region_step;
        float sum = 0;
        for (int i = 0; i < region_samples; ++i)
          sum += weights.sample[static_cast<std::size_t>(i)] * values[i];
        *out = weight * sum;
        norm2 += *out * *out;
        ++out;
      }
    }
  // Means of 8-bit grey values: below this the patch is flat and the sums are rounding.
  const float factor = norm2 > 1e-4f ? 1.f / std::sqrt(norm2) : 0.f;
  for (int k = 0; k < 16 * Kinds; ++k) descriptor[k] *= factor;
}

PatchPose descriptor_pose(float x, float y, float scale, float angle) {
  return {x, y, std::cos(angle), std::sin(angle), patch_pitch * scale};
}

// Sums over windows that begin at each bin, as differences of running sums.
void smooth(float* histogram) {
  float until[bins + window + 1];
  until[0] = 0;
  for (int k = 0; k < bins + window; ++k) until[k + 1] = until[k] + histogram[k % bins];
  for (int k = 0; k < bins; ++k) histogram[k] = until[k + window] - until[k];
}

}  // namespace

float dominant_orientation(const PatchSampler& sampler, float x, float y, float scale) {
  static const Disc disc;
  float patch[means * means + 7], all_dx[wavelets * wavelets], all_dy[wavelets * wavelets];
  sampler.sample({x, y, 1.f, 0.f, patch_pitch * scale}, means, patch);
  weighted_wavelets(patch, disc.weights.data(), all_dx, all_dy);

  constexpr int padded = (in_disc + 7) / 8 * 8;  // whole vectors
  float dx[padded] = {}, dy[padded] = {}, angle[padded];
  for (std::size_t k = 0; k < in_disc; ++k) {
    dx[k] = all_dx[disc.inside[k]];
    dy[k] = all_dy[disc.inside[k]];
  }
  turns(dx, dy, padded, angle);

  float bin_x[bins] = {}, bin_y[bins] = {};
  for (int k = 0; k < in_disc; ++k) {
    const int bin = std::min(static_cast<int>(angle[k] * bins), bins - 1);
    bin_x[bin] += dx[k];
    bin_y[bin] += dy[k];
  }
  smooth(bin_x);
  smooth(bin_x);
  smooth(bin_y);
  smooth(bin_y);
  float best_length2 = 0, best_x = 0, best_y = 0;
  for (int k = 0; k < bins; ++k) {
    const float length2 = bin_x[k] * bin_x[k] + bin_y[k] * bin_y[k];
    if (length2 > best_length2) {
      best_length2 = length2;
      best_x = bin_x[k];
      best_y = bin_y[k];
    }
  }
  if (best_length2 == 0) return 0;
  const float direction = std::atan2(best_y, best_x);
  return direction < 0 ? std::min(direction + 2 * pi, 2 * pi) : direction;
}

void describe(const PatchSampler& sampler, float x, float y, float scale, float angle, float* descriptor) {
  describe_regions<4>(sampler, descriptor_pose(x, y, scale, angle), sum_rows_64, descriptor);
}

void describe_extended(const PatchSampler& sampler, float x, float y, float scale, float angle,
                       float* descriptor) {
  describe_regions<8>(sampler, descriptor_pose(x, y, scale, angle), sum_rows_128, descriptor);
}

}  // namespace lcmslam
