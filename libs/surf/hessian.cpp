#include "surf/hessian.hpp"

#include <algorithm>
#include <opencv2/core/utility.hpp>

namespace lcmslam {
namespace {

// Vertical parts of the three filters, one number a column: the horizontal parts are differences in it.
struct ColumnSums {
  std::vector<std::uint32_t> xx, yy, xy;

  explicit ColumnSums(int width) {
    for (auto* sums : {&xx, &yy, &xy}) sums->resize(static_cast<std::size_t>(width) + 1);
  }

  void compute(const IntegralImage& integral, int lobe, int y) {
    const int half = (3 * lobe - 1) / 2, middle = (lobe - 1) / 2, width = integral.width();
    const std::uint32_t* xx_top = integral.row(y - lobe + 1);
    const std::uint32_t* xx_bottom = integral.row(y + lobe);
    const std::uint32_t* yy_top = integral.row(y - half);
    const std::uint32_t* yy_bottom = integral.row(y + half + 1);
    const std::uint32_t* middle_top = integral.row(y - middle);
    const std::uint32_t* middle_bottom = integral.row(y + middle + 1);
    const std::uint32_t* upper_top = integral.row(y - lobe);
    const std::uint32_t* upper_bottom = integral.row(y);
    const std::uint32_t* lower_top = integral.row(y + 1);
    const std::uint32_t* lower_bottom = integral.row(y + lobe + 1);
    std::uint32_t* out_xx = xx.data();
    std::uint32_t* out_yy = yy.data();
    std::uint32_t* out_xy = xy.data();
    for (int x = 0; x <= width; ++x) out_xx[x] = xx_bottom[x] - xx_top[x];
    for (int x = 0; x <= width; ++x)
      out_yy[x] = (yy_bottom[x] - yy_top[x]) - 3u * (middle_bottom[x] - middle_top[x]);
    for (int x = 0; x <= width; ++x)
      out_xy[x] = (upper_bottom[x] - upper_top[x]) - (lower_bottom[x] - lower_top[x]);
  }
};

// Step is a template argument so that the dense first octave gets contiguous, vectorised loads.
template <int Step>
void determinant_row(const ColumnSums& sums, const HessianLayer& layer, int step, float* out) {
  const int stride = Step > 0 ? Step : step;
  const int lobe = layer.lobe, half = (3 * lobe - 1) / 2, middle = (lobe - 1) / 2;
  const float inverse_area = 1.f / static_cast<float>(lobe * (2 * lobe - 1));
  const float weight2 = static_cast<float>(2 * lobe - 1) / static_cast<float>(2 * lobe);
  const std::uint32_t* xx = sums.xx.data() + layer.first_column * stride;
  const std::uint32_t* yy = sums.yy.data() + layer.first_column * stride;
  const std::uint32_t* xy = sums.xy.data() + layer.first_column * stride;
  const int n = layer.last_column - layer.first_column + 1;
  out += layer.first_column;
  for (int i = 0; i < n; ++i) {
    const int x = i * stride;
    const auto sum_xx = static_cast<std::int32_t>((xx[x + half + 1] - xx[x - half]) -
                                                  3u * (xx[x + middle + 1] - xx[x - middle]));
    const auto sum_yy = static_cast<std::int32_t>(yy[x + lobe] - yy[x - lobe + 1]);
    const auto sum_xy = static_cast<std::int32_t>((xy[x] - xy[x - lobe]) - (xy[x + lobe + 1] - xy[x + 1]));
    const float d_xx = static_cast<float>(sum_xx) * inverse_area;
    const float d_yy = static_cast<float>(sum_yy) * inverse_area;
    const float d_xy = static_cast<float>(sum_xy) * inverse_area;
    out[i] = d_xx * d_yy - weight2 * (d_xy * d_xy);
  }
}

void set_geometry(HessianLayer& layer, const IntegralImage& integral, int lobe, int step) {
  const int half = (3 * lobe - 1) / 2;
  layer.lobe = lobe;
  layer.step = step;
  layer.columns = (integral.width() - 1) / step + 1;
  layer.rows = (integral.height() - 1) / step + 1;
  layer.first_column = layer.first_row = (half + step - 1) / step;
  layer.last_column = integral.width() - 1 < half ? -1 : (integral.width() - 1 - half) / step;
  layer.last_row = integral.height() - 1 < half ? -1 : (integral.height() - 1 - half) / step;
  layer.determinants.resize(static_cast<std::size_t>(layer.columns) * static_cast<std::size_t>(layer.rows));
}

void fill_from_filters(HessianLayer& layer, const IntegralImage& integral) {
  if (layer.last_column < layer.first_column || layer.last_row < layer.first_row) return;
  cv::parallel_for_(cv::Range(layer.first_row, layer.last_row + 1), [&](const cv::Range& rows) {
    ColumnSums sums(integral.width());
    for (int r = rows.start; r < rows.end; ++r) {
      sums.compute(integral, layer.lobe, r * layer.step);
      if (layer.step == 1)
        determinant_row<1>(sums, layer, 1, layer.row(r));
      else
        determinant_row<0>(sums, layer, layer.step, layer.row(r));
    }
  });
}

// A filter that the octave below also has: every second sample of every second row.
void fill_from_finer(HessianLayer& layer, const HessianLayer& finer) {
  for (int r = layer.first_row; r <= layer.last_row; ++r) {
    const float* source = finer.row(2 * r);
    float* out = layer.row(r);
    for (int c = layer.first_column; c <= layer.last_column; ++c) out[c] = source[2 * c];
  }
}

}  // namespace

BoxHessian box_hessian(const IntegralImage& integral, int lobe, int x, int y) {
  const int half = (3 * lobe - 1) / 2, middle = (lobe - 1) / 2;
  BoxHessian sums;
  sums.xx = integral.box(x - half, y - lobe + 1, x + half + 1, y + lobe) -
            3 * integral.box(x - middle, y - lobe + 1, x + middle + 1, y + lobe);
  sums.yy = integral.box(x - lobe + 1, y - half, x + lobe, y + half + 1) -
            3 * integral.box(x - lobe + 1, y - middle, x + lobe, y + middle + 1);
  sums.xy = integral.box(x - lobe, y - lobe, x, y) + integral.box(x + 1, y + 1, x + lobe + 1, y + lobe + 1) -
            integral.box(x + 1, y - lobe, x + lobe + 1, y) - integral.box(x - lobe, y + 1, x, y + lobe + 1);
  return sums;
}

void HessianPyramid::compute(const IntegralImage& integral, int octaves, int intervals) {
  layers_.resize(static_cast<std::size_t>(octaves));
  for (int o = 0; o < octaves; ++o) {
    auto& layers = layers_[static_cast<std::size_t>(o)];
    layers.resize(static_cast<std::size_t>(intervals));
    for (int i = 0; i < intervals; ++i) {
      HessianLayer& layer = layers[static_cast<std::size_t>(i)];
      set_geometry(layer, integral, (2 << o) * (i + 1) + 1, 1 << o);
      const HessianLayer* finer = nullptr;
      if (o > 0)
        for (const HessianLayer& below : layers_[static_cast<std::size_t>(o - 1)])
          if (below.lobe == layer.lobe) finer = &below;
      if (finer)
        fill_from_finer(layer, *finer);
      else
        fill_from_filters(layer, integral);
    }
  }
}

}  // namespace lcmslam
