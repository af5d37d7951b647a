#include <lcmslam/surf/hessian.hpp>

#include <algorithm>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/parallel/rows.hpp>

namespace lcmslam {
namespace {

// Vertical parts of the three filters, one number a column: the horizontal parts are differences in it.
struct ColumnSums {
  std::vector<std::uint32_t> xx, yy, xy;
};

struct IntegralRows {
  const std::uint32_t *xx_top, *xx_bottom, *yy_top, *yy_bottom, *middle_top, *middle_bottom;
  const std::uint32_t *upper_top, *upper_bottom, *lower_top, *lower_bottom;

  IntegralRows(const IntegralImage& integral, int lobe, int y)
      : xx_top(integral.row(y - lobe + 1)),
        xx_bottom(integral.row(y + lobe)),
        yy_top(integral.row(y - (3 * lobe - 1) / 2)),
        yy_bottom(integral.row(y + (3 * lobe + 1) / 2)),
        middle_top(integral.row(y - (lobe - 1) / 2)),
        middle_bottom(integral.row(y + (lobe + 1) / 2)),
        upper_top(integral.row(y - lobe)),
        upper_bottom(integral.row(y)),
        lower_top(integral.row(y + 1)),
        lower_bottom(integral.row(y + lobe + 1)) {}
};

LCMSLAM_VECTORISED(sum_columns,
                   (const IntegralRows& in, int n, std::uint32_t* __restrict xx, std::uint32_t* __restrict yy,
                    std::uint32_t* __restrict xy),
                   (in, n, xx, yy, xy)) {
  const IntegralRows rows = in;  // local: nothing that is written can change it
  for (int x = 0; x < n; ++x) {
    xx[x] = rows.xx_bottom[x] - rows.xx_top[x];
    yy[x] = (rows.yy_bottom[x] - rows.yy_top[x]) - 3u * (rows.middle_bottom[x] - rows.middle_top[x]);
    xy[x] = (rows.upper_bottom[x] - rows.upper_top[x]) - (rows.lower_bottom[x] - rows.lower_top[x]);
  }
}

// Step is a template argument so that the steps of the first octaves get vectorised loads.
template <int Step>
__attribute__((always_inline)) inline void determinant_loop(const std::uint32_t* xx, const std::uint32_t* yy,
                                                            const std::uint32_t* xy, int lobe, int step,
                                                            int n, float* __restrict out) {
  const int stride = Step > 0 ? Step : step;
  const int half = (3 * lobe - 1) / 2, middle = (lobe - 1) / 2;
  const float inverse_area = 1.f / static_cast<float>(lobe * (2 * lobe - 1));
  const float weight2 = determinant_weight2(lobe);
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

LCMSLAM_VECTORISED(determinant_row,
                   (const std::uint32_t* xx, const std::uint32_t* yy, const std::uint32_t* xy, int lobe,
                    int step, int n, float* out),
                   (xx, yy, xy, lobe, step, n, out)) {
  switch (step) {
    case 1:
      return determinant_loop<1>(xx, yy, xy, lobe, step, n, out);
    case 2:
      return determinant_loop<2>(xx, yy, xy, lobe, step, n, out);
    case 4:
      return determinant_loop<4>(xx, yy, xy, lobe, step, n, out);
    default:
      return determinant_loop<0>(xx, yy, xy, lobe, step, n, out);
  }
}

void fill_row(HessianLayer& layer, const IntegralImage& integral, int r) {
  thread_local ColumnSums sums;
  const auto width = static_cast<std::size_t>(integral.width()) + 1;
  for (auto* values : {&sums.xx, &sums.yy, &sums.xy})
    if (values->size() < width) values->resize(width);
  const IntegralRows rows(integral, layer.lobe, r * layer.step);
  sum_columns(rows, integral.width() + 1, sums.xx.data(), sums.yy.data(), sums.xy.data());
  const int x = layer.first_column * layer.step;
  determinant_row(sums.xx.data() + x, sums.yy.data() + x, sums.xy.data() + x, layer.lobe, layer.step,
                  layer.last_column - layer.first_column + 1, layer.row(r) + layer.first_column);
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

int step_of(int octave) {
  return octave == 0 ? 1 : 1 << (octave - 1);
}

// A filter that the octave below also has: every second sample of every second row.
void copy_row(HessianLayer& layer, const HessianLayer& finer, int r) {
  const float* source = finer.row(2 * r);
  float* out = layer.row(r);
  for (int c = layer.first_column; c <= layer.last_column; ++c) out[c] = source[2 * c];
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
  octaves_ = octaves;
  intervals_ = intervals;
  slots_.clear();
  std::size_t used = 0;  // of layers_, which keep their memory
  for (int o = 0; o < octaves; ++o) {
    const int step = step_of(o);
    const std::size_t first_new = used;
    for (int i = 0; i < intervals; ++i) {
      const int lobe = (2 << o) * (i + 1) + 1;
      const auto shared =
          std::find_if(layers_.begin(), layers_.begin() + static_cast<std::ptrdiff_t>(used),
                       [&](const HessianLayer& l) { return l.lobe == lobe && l.step == step; });
      slots_.push_back(static_cast<std::size_t>(shared - layers_.begin()));
      if (slots_.back() < used) continue;
      if (layers_.size() == used) layers_.emplace_back();
      set_geometry(layers_[used++], integral, lobe, step);
    }
    const auto finer_with = [&](int lobe) -> const HessianLayer* {
      for (std::size_t l = 0; l < first_new; ++l)
        if (layers_[l].lobe == lobe && 2 * layers_[l].step == step) return &layers_[l];
      return nullptr;
    };
    // All layers of some rows together: they read the same rows of the integral image.
    parallel_rows(0, (integral.height() - 1) / step + 1, [&](int begin, int end) {
      for (int r = begin; r < end; ++r)
        for (std::size_t l = first_new; l < used; ++l) {
          HessianLayer& layer = layers_[l];
          if (r < layer.first_row || r > layer.last_row || layer.last_column < layer.first_column) continue;
          if (const HessianLayer* finer = finer_with(layer.lobe))
            copy_row(layer, *finer, r);
          else
            fill_row(layer, integral, r);
        }
    });
  }
}

}  // namespace lcmslam
