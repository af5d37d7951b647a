#include "surf/extrema.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <optional>

namespace lcmslam {
namespace {

// The sample's neighbourhood: at(s, y, x) with offsets -1..1.
struct Neighbourhood {
  const HessianLayer* layers[3];
  int column, row;

  float at(int s, int y, int x) const { return layers[s + 1]->row(row + y)[column + x]; }

  bool is_maximum() const {
    const float value = at(0, 0, 0);
    for (int s = -1; s <= 1; ++s)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const int order = 9 * s + 3 * y + x;
          if (order < 0 ? at(s, y, x) >= value : at(s, y, x) > value) return false;
        }
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

void find_in_layer(const HessianLayer& below, const HessianLayer& layer, const HessianLayer& above,
                   const IntegralImage& integral, float threshold, int octave, std::vector<Blob>& blobs) {
  // The largest filter has the smallest valid region.
  for (int r = above.first_row + 1; r < above.last_row; ++r) {
    const float* values = layer.row(r);
    for (int c = above.first_column + 1; c < above.last_column; ++c) {
      if (values[c] <= threshold) continue;
      const Neighbourhood neighbourhood{{&below, &layer, &above}, c, r};
      if (!neighbourhood.is_maximum()) continue;
      const auto peak = quadric_peak(neighbourhood);
      if (!peak) continue;
      Blob blob;
      const auto step = static_cast<float>(layer.step);
      blob.x = (static_cast<float>(c) + peak->offset.x()) * step;
      blob.y = (static_cast<float>(r) + peak->offset.y()) * step;
      blob.size = static_cast<float>(3 * layer.lobe) * std::exp(peak->offset.z());
      blob.response = peak->value;
      const BoxHessian sums = box_hessian(integral, layer.lobe, c * layer.step, r * layer.step);
      blob.laplacian = sums.xx + sums.yy < 0 ? -1 : 1;
      blob.octave = octave;
      blobs.push_back(blob);
    }
  }
}

}  // namespace

std::vector<Blob> find_blobs(const HessianPyramid& pyramid, const IntegralImage& integral, float threshold) {
  std::vector<Blob> blobs;
  for (int o = 0; o < pyramid.octaves(); ++o) {
    const auto& layers = pyramid.octave(o);
    for (std::size_t i = 1; i + 1 < layers.size(); ++i)
      find_in_layer(layers[i - 1], layers[i], layers[i + 1], integral, threshold, o, blobs);
  }
  return blobs;
}

}  // namespace lcmslam
