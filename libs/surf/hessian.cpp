#include <lcmslam/surf/hessian.hpp>

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/parallel/rows.hpp>

namespace lcmslam {
namespace {

// Filters up to this lobe have sums below 2^15 of 8-bit pixels: 255 * 2 lobe (2 lobe - 1) for Dxx and Dyy,
// less for Dxy. Modulo 2^16 they are right, and twice as many fit into a register.
constexpr int widest_low_lobe = 5;
static_assert(255 * 2 * widest_low_lobe * (2 * widest_low_lobe - 1) < 1 << 15);

// Vertical parts of the three filters, one number a column: the horizontal parts are differences in it.
template <class Sum>
struct ColumnSums {
  std::vector<Sum> xx, yy, xy;

  void make_room(std::size_t columns) {
    for (auto* values : {&xx, &yy, &xy})
      if (values->size() < columns) values->resize(columns);
  }
};

template <class Sum>
struct IntegralRows {
  const Sum *xx_top, *xx_bottom, *yy_top, *yy_bottom, *middle_top, *middle_bottom;
  const Sum *upper_top, *upper_bottom, *lower_top, *lower_bottom;

  template <class Row>
  IntegralRows(const Row& row, int lobe, int y)
      : xx_top(row(y - lobe + 1)),
        xx_bottom(row(y + lobe)),
        yy_top(row(y - (3 * lobe - 1) / 2)),
        yy_bottom(row(y + (3 * lobe + 1) / 2)),
        middle_top(row(y - (lobe - 1) / 2)),
        middle_bottom(row(y + (lobe + 1) / 2)),
        upper_top(row(y - lobe)),
        upper_bottom(row(y)),
        lower_top(row(y + 1)),
        lower_bottom(row(y + lobe + 1)) {}
};

template <class Sum>
__attribute__((always_inline)) inline void sum_columns_loop(const IntegralRows<Sum>& in, int n,
                                                            Sum* __restrict xx, Sum* __restrict yy,
                                                            Sum* __restrict xy) {
  const IntegralRows<Sum> rows = in;  // local: nothing that is written can change it
  for (int x = 0; x < n; ++x) {
    xx[x] = static_cast<Sum>(rows.xx_bottom[x] - rows.xx_top[x]);
    yy[x] = static_cast<Sum>((rows.yy_bottom[x] - rows.yy_top[x]) -
                             Sum{3} * (rows.middle_bottom[x] - rows.middle_top[x]));
    xy[x] = static_cast<Sum>((rows.upper_bottom[x] - rows.upper_top[x]) -
                             (rows.lower_bottom[x] - rows.lower_top[x]));
  }
}

LCMSLAM_VECTORISED(sum_columns,
                   (const IntegralRows<std::uint32_t>& in, int n, std::uint32_t* xx, std::uint32_t* yy,
                    std::uint32_t* xy),
                   (in, n, xx, yy, xy)) {
  sum_columns_loop(in, n, xx, yy, xy);
}

LCMSLAM_VECTORISED(sum_low_columns,
                   (const IntegralRows<std::uint16_t>& in, int n, std::uint16_t* xx, std::uint16_t* yy,
                    std::uint16_t* xy),
                   (in, n, xx, yy, xy)) {
  sum_columns_loop(in, n, xx, yy, xy);
}

// Step is a template argument so that the steps of the first octaves get vectorised loads.
template <int Step, class Sum>
__attribute__((always_inline)) inline void determinant_loop(const Sum* xx, const Sum* yy, const Sum* xy,
                                                            int lobe, int step, int n,
                                                            float* __restrict out) {
  using Signed = std::make_signed_t<Sum>;
  const int stride = Step > 0 ? Step : step;
  const int half = (3 * lobe - 1) / 2, middle = (lobe - 1) / 2;
  const float inverse_area = 1.f / static_cast<float>(lobe * (2 * lobe - 1));
  const float weight2 = determinant_weight2(lobe);
  for (int i = 0; i < n; ++i) {
    const int x = i * stride;
    const auto sum_xx = static_cast<Signed>(
        static_cast<Sum>((xx[x + half + 1] - xx[x - half]) - Sum{3} * (xx[x + middle + 1] - xx[x - middle])));
    const auto sum_yy = static_cast<Signed>(static_cast<Sum>(yy[x + lobe] - yy[x - lobe + 1]));
    const auto sum_xy =
        static_cast<Signed>(static_cast<Sum>((xy[x] - xy[x - lobe]) - (xy[x + lobe + 1] - xy[x + 1])));
    const float d_xx = static_cast<float>(sum_xx) * inverse_area;
    const float d_yy = static_cast<float>(sum_yy) * inverse_area;
    const float d_xy = static_cast<float>(sum_xy) * inverse_area;
    out[i] = d_xx * d_yy - weight2 * (d_xy * d_xy);
  }
}

LCMSLAM_VECTORISED(low_determinant_row,
                   (const std::uint16_t* xx, const std::uint16_t* yy, const std::uint16_t* xy, int lobe,
                    int n, float* out),
                   (xx, yy, xy, lobe, n, out)) {
  determinant_loop<1>(xx, yy, xy, lobe, 1, n, out);
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

LCMSLAM_VECTORISED(take_low, (const std::uint32_t* __restrict sums, int n, std::uint16_t* __restrict low),
                   (sums, n, low)) {
  for (int i = 0; i < n; ++i) low[i] = static_cast<std::uint16_t>(sums[i]);
}

/// An integral image modulo 2^16.
class LowSums {
 public:
  void set(const IntegralImage& integral) {
    stride_ = static_cast<std::size_t>(integral.width()) + 1;
    sums_.resize(stride_ * (static_cast<std::size_t>(integral.height()) + 1));
    take_low(integral.row(0), static_cast<int>(sums_.size()), sums_.data());
  }
  const std::uint16_t* row(int y) const { return sums_.data() + static_cast<std::size_t>(y) * stride_; }

 private:
  std::size_t stride_ = 0;
  std::vector<std::uint16_t> sums_;
};

void fill_row(HessianLayer& layer, const IntegralImage& integral, const LowSums& low, int r) {
  thread_local ColumnSums<std::uint32_t> sums;
  thread_local ColumnSums<std::uint16_t> low_sums;
  const int columns = integral.width() + 1, n = layer.last_column - layer.first_column + 1;
  const int x = layer.first_column * layer.step, y = r * layer.step;
  float* const out = layer.row(r) + layer.first_column;
  if (layer.lobe <= widest_low_lobe && layer.step == 1) {
    const IntegralRows<std::uint16_t> rows([&](int row) { return low.row(row); }, layer.lobe, y);
    low_sums.make_room(static_cast<std::size_t>(columns));
    sum_low_columns(rows, columns, low_sums.xx.data(), low_sums.yy.data(), low_sums.xy.data());
    low_determinant_row(low_sums.xx.data() + x, low_sums.yy.data() + x, low_sums.xy.data() + x, layer.lobe, n,
                        out);
  } else {
    const IntegralRows<std::uint32_t> rows([&](int row) { return integral.row(row); }, layer.lobe, y);
    sums.make_room(static_cast<std::size_t>(columns));
    sum_columns(rows, columns, sums.xx.data(), sums.yy.data(), sums.xy.data());
    determinant_row(sums.xx.data() + x, sums.yy.data() + x, sums.xy.data() + x, layer.lobe, layer.step, n,
                    out);
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
  thread_local LowSums sums_of_this_thread;  // their memory is kept
  sums_of_this_thread.set(integral);
  const LowSums& low = sums_of_this_thread;
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
            fill_row(layer, integral, low, r);
        }
    });
  }
}

}  // namespace lcmslam
