#include <lcmslam/surf/patch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/parallel/rows.hpp>
#ifdef LCMSLAM_HAS_AVX2
#include <immintrin.h>
#endif

namespace lcmslam {
namespace {

constexpr float fixed_point = 256;  // of the means

std::uint16_t fixed_mean(std::int32_t sum, float factor) {
  return static_cast<std::uint16_t>(static_cast<std::int32_t>(static_cast<float>(sum) * factor + 0.5f));
}

// Boxes of `side` columns that lie within the image.
LCMSLAM_VECTORISED(filter_row,
                   (const std::uint32_t* top, const std::uint32_t* bottom, int side, int n, float factor,
                    std::uint16_t* out),
                   (top, bottom, side, n, factor, out)) {
  for (int x = 0; x < n; ++x) {
    const std::uint32_t sum = (bottom[x + side] - bottom[x]) - (top[x + side] - top[x]);
    out[x] = static_cast<std::uint16_t>(
        static_cast<std::int32_t>(static_cast<float>(static_cast<std::int32_t>(sum)) * factor + 0.5f));
  }
}

// A patch's grid in the pixels of its copy.
struct Grid {
  const std::uint16_t* means;
  int stride;
  float x, y;            // centre
  float step_x, step_y;  // to the next column; to the next row (-step_y, step_x)
  float last_x, last_y;  // of the copy
  int n;
};

// The interpolated mean; comparisons in this order send NaN to the border.
float mean_at(const Grid& g, float x, float y) {
  x = x > 0.f ? x : 0.f;
  y = y > 0.f ? y : 0.f;
  x = x < g.last_x ? x : g.last_x;
  y = y < g.last_y ? y : g.last_y;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const float fraction_x = x - static_cast<float>(column), fraction_y = y - static_cast<float>(row);
  const std::uint16_t* upper = g.means + static_cast<std::ptrdiff_t>(row) * g.stride + column;
  const std::uint16_t* lower = upper + g.stride;
  const auto a = static_cast<float>(upper[0]), b = static_cast<float>(upper[1]);
  const auto c = static_cast<float>(lower[0]), d = static_cast<float>(lower[1]);
  const float above = a + fraction_x * (b - a), below = c + fraction_x * (d - c);
  return (above + fraction_y * (below - above)) * (1.f / fixed_point);
}

void sample_baseline(const Grid& g, float* patch) {
  const float half = 0.5f * static_cast<float>(g.n - 1);
  for (int j = 0; j < g.n; ++j) {
    const float v = static_cast<float>(j) - half;
    const float row_x = g.x - v * g.step_y, row_y = g.y + v * g.step_x;
    for (int i = 0; i < g.n; ++i) {
      const float u = static_cast<float>(i) - half;
      patch[j * g.n + i] = mean_at(g, row_x + u * g.step_x, row_y + u * g.step_y);
    }
  }
}

#ifdef LCMSLAM_HAS_AVX2
// The same operations in the same order, eight points at once; one gather fetches two neighbours.
LCMSLAM_AVX2 void sample_avx2(const Grid& g, float* patch) {
  const float half = 0.5f * static_cast<float>(g.n - 1);
  const __m256 zero = _mm256_setzero_ps(), scale = _mm256_set1_ps(1.f / fixed_point);
  const __m256 last_x = _mm256_set1_ps(g.last_x), last_y = _mm256_set1_ps(g.last_y);
  const __m256 step_x = _mm256_set1_ps(g.step_x), step_y = _mm256_set1_ps(g.step_y);
  const __m256i stride = _mm256_set1_epi32(g.stride), low = _mm256_set1_epi32(0xffff);
  const auto* upper_row = reinterpret_cast<const int*>(g.means);
  const auto* lower_row = reinterpret_cast<const int*>(g.means + g.stride);
  const __m256 eight = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
  for (int j = 0; j < g.n; ++j) {
    const float v = static_cast<float>(j) - half;
    const __m256 row_x = _mm256_set1_ps(g.x - v * g.step_y), row_y = _mm256_set1_ps(g.y + v * g.step_x);
    for (int i = 0; i < g.n; i += 8) {  // beyond n: overwritten by the next row, or in the reserve
      const __m256 u =
          _mm256_sub_ps(_mm256_add_ps(_mm256_set1_ps(static_cast<float>(i)), eight), _mm256_set1_ps(half));
      __m256 x = _mm256_add_ps(row_x, _mm256_mul_ps(u, step_x));
      __m256 y = _mm256_add_ps(row_y, _mm256_mul_ps(u, step_y));
      x = _mm256_min_ps(_mm256_max_ps(x, zero), last_x);
      y = _mm256_min_ps(_mm256_max_ps(y, zero), last_y);
      const __m256i column = _mm256_cvttps_epi32(x), row = _mm256_cvttps_epi32(y);
      const __m256 fraction_x = _mm256_sub_ps(x, _mm256_cvtepi32_ps(column));
      const __m256 fraction_y = _mm256_sub_ps(y, _mm256_cvtepi32_ps(row));
      const __m256i index = _mm256_add_epi32(_mm256_mullo_epi32(row, stride), column);
      const __m256i upper = _mm256_i32gather_epi32(upper_row, index, 2);
      const __m256i lower = _mm256_i32gather_epi32(lower_row, index, 2);
      const __m256 a = _mm256_cvtepi32_ps(_mm256_and_si256(upper, low));
      const __m256 b = _mm256_cvtepi32_ps(_mm256_srli_epi32(upper, 16));
      const __m256 c = _mm256_cvtepi32_ps(_mm256_and_si256(lower, low));
      const __m256 d = _mm256_cvtepi32_ps(_mm256_srli_epi32(lower, 16));
      const __m256 above = _mm256_add_ps(a, _mm256_mul_ps(fraction_x, _mm256_sub_ps(b, a)));
      const __m256 below = _mm256_add_ps(c, _mm256_mul_ps(fraction_x, _mm256_sub_ps(d, c)));
      const __m256 mean = _mm256_add_ps(above, _mm256_mul_ps(fraction_y, _mm256_sub_ps(below, above)));
      _mm256_storeu_ps(patch + j * g.n + i, _mm256_mul_ps(mean, scale));
    }
  }
}
#endif

}  // namespace

PatchSampler::Copy PatchSampler::copy_for(float pitch) const {
  float side = box_per_pitch * pitch;
  Copy copy;
  while (!(side < max_side + 0.5f) && copy.level + 1 < level_count_) {
    side *= 0.5f;
    ++copy.level;
  }
  copy.side = static_cast<int>(std::min(std::max(side, 1.f) + 0.5f, static_cast<float>(max_side)));
  return copy;
}

void PatchSampler::prepare(const IntegralImage& integral, const std::vector<float>& pitches) {
  constexpr int least_width = 4;
  integral_ = &integral;
  level_count_ = 1;
  while (level_count_ < max_levels &&
         (std::min(integral.width(), integral.height()) >> level_count_) >= least_width)
    ++level_count_;
  for (Level& level : levels_)
    for (Filtered& filtered : level.by_side) filtered.ready = false;
  int halved = 0;
  for (const float pitch : pitches) {
    const Copy copy = copy_for(pitch);
    for (; halved < copy.level; ++halved)
      levels_[static_cast<std::size_t>(halved + 1)].halved.halve(this->integral(halved));
    if (!levels_[static_cast<std::size_t>(copy.level)].by_side[static_cast<std::size_t>(copy.side)].ready)
      filter(copy);
  }
}

void PatchSampler::filter(Copy copy) {
  const IntegralImage& sums = integral(copy.level);
  const int width = sums.width(), height = sums.height(), side = copy.side, before = side / 2;
  const auto stride = static_cast<std::size_t>(width) + 1;
  Filtered& filtered =
      levels_[static_cast<std::size_t>(copy.level)].by_side[static_cast<std::size_t>(copy.side)];
  filtered.ready = true;
  auto& means = filtered.means;
  means.resize(stride * static_cast<std::size_t>(height + 1) + 1);
  const int first = std::min(before, width), last = std::max(first, width - side + before + 1);
  const float unit = fixed_point / static_cast<float>(1 << (2 * copy.level));
  parallel_rows(0, height, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) {
      std::uint16_t* out = means.data() + static_cast<std::size_t>(y) * stride;
      const int y0 = std::max(0, y - before), y1 = std::min(y - before + side, height);
      const auto cut_box = [&](int x) {  // at the border a box is cut to the image
        const int x0 = std::max(0, x - before), x1 = std::min(x - before + side, width);
        return fixed_mean(sums.box(x0, y0, x1, y1), unit / static_cast<float>((x1 - x0) * (y1 - y0)));
      };
      for (int x = 0; x < first; ++x) out[x] = cut_box(x);
      filter_row(sums.row(y0) + first - before, sums.row(y1) + first - before, side, last - first,
                 unit / static_cast<float>(side * (y1 - y0)), out + first);
      for (int x = last; x < width; ++x) out[x] = cut_box(x);
      out[width] = out[width - 1];
    }
  });
  std::uint16_t* end = means.data() + stride * static_cast<std::size_t>(height);
  std::memcpy(end, end - stride, stride * sizeof *end);
}

void PatchSampler::sample(const PatchPose& pose, int n, float* patch) const {
  const Copy copy = copy_for(pose.pitch);
  const IntegralImage& sums = integral(copy.level);
  const auto& means =
      levels_[static_cast<std::size_t>(copy.level)].by_side[static_cast<std::size_t>(copy.side)].means;
  const float size = 1.f / static_cast<float>(1 << copy.level);  // of an image's pixel in the copy
  const float box_centre = copy.side % 2 == 0 ? 0.5f : 0.f;      // the box of x is centred on x - box_centre
  const Grid grid{means.data(),
                  sums.width() + 1,
                  (pose.x + 0.5f) * size - 0.5f + box_centre,
                  (pose.y + 0.5f) * size - 0.5f + box_centre,
                  pose.cosine * pose.pitch * size,
                  pose.sine * pose.pitch * size,
                  static_cast<float>(sums.width() - 1),
                  static_cast<float>(sums.height() - 1),
                  n};
#ifdef LCMSLAM_HAS_AVX2
  if (best_instruction_set() == InstructionSet::avx2) return sample_avx2(grid, patch);
#endif
  sample_baseline(grid, patch);
}

}  // namespace lcmslam
