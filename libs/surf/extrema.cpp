#include <lcmslam/surf/extrema.hpp>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/parallel/rows.hpp>

namespace lcmslam {
namespace {

inline float larger(float a, float b) {
  return a > b ? a : b;
}

constexpr int piece = 32;  // samples of a row that are looked at together

/// 1 where a sample is above the threshold and its eight neighbours: earlier ones are less, later ones at
/// most equal. So are its places in the layers below and above, which leave few for a look at all of those.
struct PeakMarks {
  const float *upper, *row, *lower, *below, *above;
  float threshold;

  __attribute__((always_inline)) bool may_be_within(int begin, int end) const {
    std::int32_t any = 0;
    for (int c = begin; c < end; ++c) any |= row[c] > threshold ? -1 : 0;
    return any != 0;
  }
  __attribute__((always_inline)) void write(int begin, int end, std::uint8_t* __restrict marks) const {
    for (int c = begin; c < end; ++c) {
      const float less = larger(larger(larger(threshold, upper[c - 1]), larger(upper[c], upper[c + 1])),
                                larger(row[c - 1], below[c]));
      const float at_most =
          larger(larger(row[c + 1], lower[c - 1]), larger(larger(lower[c], lower[c + 1]), above[c]));
      const float value = row[c];
      marks[c] = static_cast<std::uint8_t>((value > less) & (value >= at_most));
    }
  }
};

// Most pieces have no sample above the threshold.
LCMSLAM_VECTORISED(mark_peaks, (const PeakMarks& of, int n, std::uint8_t* __restrict marks), (of, n, marks)) {
  const PeakMarks peaks = of;  // local: nothing that is written can change it
  int begin = 0;
  for (; begin + piece <= n; begin += piece)
    if (peaks.may_be_within(begin, begin + piece))
      peaks.write(begin, begin + piece, marks);
    else
      std::fill_n(marks + begin, piece, std::uint8_t{0});
  peaks.write(begin, n, marks);
}

// The sample's neighbourhood: at(s, y, x) with offsets -1..1.
struct Neighbourhood {
  const HessianLayer* layers[3];
  int column, row;

  float at(int s, int y, int x) const { return layers[s + 1]->row(row + y)[column + x]; }

  // Among the layers below and above; mark_peaks has looked at its own.
  bool is_maximum_over_scale() const {
    const float value = at(0, 0, 0);
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (at(-1, y, x) >= value || at(1, y, x) > value) return false;
    return true;
  }
};

struct QuadricPeak {
  Eigen::Vector3f offset;  // samples in column and row, logarithm of the size
  float value;
};

// Second-order Taylor expansion from differences; its stationary point is -H^-1 g. The scale axis is the
// logarithm of the size, where a blob's response is nearly symmetric about its peak, though the layers
// are not evenly spaced there: by h1 to the layer below, h2 to the one above.
std::optional<QuadricPeak> quadric_peak(const Neighbourhood& n) {
  const auto log_ratio = [](int a, int b) { return std::log(static_cast<float>(a) / static_cast<float>(b)); };
  const float h1 = log_ratio(n.layers[1]->lobe, n.layers[0]->lobe);
  const float h2 = log_ratio(n.layers[2]->lobe, n.layers[1]->lobe);
  const float centre = n.at(0, 0, 0);
  const float below = n.at(-1, 0, 0) - centre, above = n.at(1, 0, 0) - centre;
  const float h = h1 * h2 * (h1 + h2);

  const Eigen::Vector3f gradient(0.5f * (n.at(0, 0, 1) - n.at(0, 0, -1)),
                                 0.5f * (n.at(0, 1, 0) - n.at(0, -1, 0)),
                                 (above * h1 * h1 - below * h2 * h2) / h);
  const float xx = n.at(0, 0, 1) + n.at(0, 0, -1) - 2 * centre;
  const float yy = n.at(0, 1, 0) + n.at(0, -1, 0) - 2 * centre;
  const float ss = 2 * (above * h1 + below * h2) / h;
  const float xy = 0.25f * (n.at(0, 1, 1) + n.at(0, -1, -1) - n.at(0, 1, -1) - n.at(0, -1, 1));
  const float xs = 0.5f * (n.at(1, 0, 1) + n.at(-1, 0, -1) - n.at(1, 0, -1) - n.at(-1, 0, 1)) / (h1 + h2);
  const float ys = 0.5f * (n.at(1, 1, 0) + n.at(-1, -1, 0) - n.at(1, -1, 0) - n.at(-1, 1, 0)) / (h1 + h2);
  Eigen::Matrix3f hessian;
  hessian << xx, xy, xs, xy, yy, ys, xs, ys, ss;
  const Eigen::Vector3f offset = -(hessian.inverse() * gradient);
  // Written so that the NaN of a singular quadric fails too.
  if (!(offset.head<2>().cwiseAbs().maxCoeff() <= 1.f && offset.z() >= -h1 && offset.z() <= h2))
    return std::nullopt;
  return QuadricPeak{offset, centre + 0.5f * gradient.dot(offset)};
}

// tr^2 / det of the Hessian grows with the ratio r of its eigenvalues: (r + 1)^2 / r.
bool on_edge(const BoxHessian& sums, int lobe, float edge_ratio) {
  const auto xx = static_cast<float>(sums.xx), yy = static_cast<float>(sums.yy);
  const auto xy = static_cast<float>(sums.xy);
  const float trace = xx + yy, determinant = xx * yy - determinant_weight2(lobe) * xy * xy;
  return trace * trace * edge_ratio > (edge_ratio + 1) * (edge_ratio + 1) * determinant;
}

void find_in_rows(const HessianLayer& below, const HessianLayer& layer, const HessianLayer& above,
                  const IntegralImage& integral, int first_row, int end_row, float threshold,
                  float edge_ratio, int octave, std::vector<Blob>& blobs) {
  thread_local std::vector<std::uint8_t> marks;
  // The largest filter has the smallest valid region.
  const int first = above.first_column + 1, n = above.last_column - first;
  if (n <= 0) return;
  if (marks.size() < static_cast<std::size_t>(n)) marks.resize(static_cast<std::size_t>(n));
  const auto step = static_cast<float>(layer.step);
  for (int r = first_row; r < end_row; ++r) {
    mark_peaks({layer.row(r - 1) + first, layer.row(r) + first, layer.row(r + 1) + first,
                below.row(r) + first, above.row(r) + first, threshold},
               n, marks.data());
    const std::uint8_t* const begin = marks.data();
    for (int i = 0; i < n; ++i) {
      const void* mark = std::memchr(begin + i, 1, static_cast<std::size_t>(n - i));
      if (!mark) break;
      i = static_cast<int>(static_cast<const std::uint8_t*>(mark) - begin);
      const int c = first + i;
      const Neighbourhood neighbourhood{{&below, &layer, &above}, c, r};
      if (!neighbourhood.is_maximum_over_scale()) continue;
      const BoxHessian sums = box_hessian(integral, layer.lobe, c * layer.step, r * layer.step);
      if (on_edge(sums, layer.lobe, edge_ratio)) continue;
      const auto peak = quadric_peak(neighbourhood);
      if (!peak) continue;
      Blob blob;
      blob.x = (static_cast<float>(c) + peak->offset.x()) * step;
      blob.y = (static_cast<float>(r) + peak->offset.y()) * step;
      blob.size = static_cast<float>(3 * layer.lobe) * std::exp(peak->offset.z());
      blob.response = peak->value;
      blob.laplacian = sums.xx + sums.yy < 0 ? -1 : 1;
      blob.octave = octave;
      blobs.push_back(blob);
    }
  }
}

}  // namespace

void BlobFinder::find(const HessianPyramid& pyramid, const IntegralImage& integral, float threshold,
                      float edge_ratio, std::vector<Blob>& blobs) {
  constexpr int band_rows = 16;
  std::size_t count = 0;
  for (int o = 0; o < pyramid.octaves(); ++o) {
    for (int i = 1; i + 1 < pyramid.intervals(); ++i) {
      const HessianLayer& above = pyramid.layer(o, i + 1);
      for (int r = above.first_row + 1; r < above.last_row; r += band_rows, ++count) {
        if (bands_.size() <= count) bands_.emplace_back();
        Band& band = bands_[count];
        band.octave = o;
        band.layer = i;
        band.first_row = r;
        band.end_row = std::min(r + band_rows, above.last_row);
      }
    }
  }
  parallel_rows(0, static_cast<int>(count), [&](int begin, int end) {
    for (int b = begin; b < end; ++b) {
      Band& band = bands_[static_cast<std::size_t>(b)];
      band.blobs.clear();
      find_in_rows(pyramid.layer(band.octave, band.layer - 1), pyramid.layer(band.octave, band.layer),
                   pyramid.layer(band.octave, band.layer + 1), integral, band.first_row, band.end_row,
                   threshold, edge_ratio, band.octave, band.blobs);
    }
  });
  blobs.clear();
  for (std::size_t b = 0; b < count; ++b)
    blobs.insert(blobs.end(), bands_[b].blobs.begin(), bands_[b].blobs.end());
}

}  // namespace lcmslam
