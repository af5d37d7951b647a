#include <lcmslam/features/pair_columns.hpp>

#include <algorithm>

#include <lcmslam/parallel/instruction_set.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t points_a = 0, points_b = 3, covariances_a = 6, covariances_b = 12, all = 18;

struct Motion {
  double r[3][3];  // R' of T_a_b
  double t[3];
};

struct PairNumbers {
  const double *ax, *ay, *az, *bx, *by, *bz;
  const double *a_xx, *a_xy, *a_xz, *a_yy, *a_yz, *a_zz;
  const double *b_xx, *b_xy, *b_xz, *b_yy, *b_yz, *b_zz;
};

LCMSLAM_VECTORISED(measure_pairs,
                   (const PairNumbers& pairs, const Motion& motion, int n, PairResiduals* __restrict out),
                   (pairs, motion, n, out)) {
  const PairNumbers p = pairs;  // local: nothing that is written can change them
  const Motion m = motion;
  for (int i = 0; i < n; ++i) {
    const double x = p.ax[i] - m.t[0], y = p.ay[i] - m.t[1], z = p.az[i] - m.t[2];
    const double ex = m.r[0][0] * x + m.r[0][1] * y + m.r[0][2] * z - p.bx[i];
    const double ey = m.r[1][0] * x + m.r[1][1] * y + m.r[1][2] * z - p.by[i];
    const double ez = m.r[2][0] * x + m.r[2][1] * y + m.r[2][2] * z - p.bz[i];

    double turned[3][3];  // R' S_a
    for (int k = 0; k < 3; ++k) {
      turned[k][0] = m.r[k][0] * p.a_xx[i] + m.r[k][1] * p.a_xy[i] + m.r[k][2] * p.a_xz[i];
      turned[k][1] = m.r[k][0] * p.a_xy[i] + m.r[k][1] * p.a_yy[i] + m.r[k][2] * p.a_yz[i];
      turned[k][2] = m.r[k][0] * p.a_xz[i] + m.r[k][1] * p.a_yz[i] + m.r[k][2] * p.a_zz[i];
    }
    const auto product = [&](int row, int column) {
      return turned[row][0] * m.r[column][0] + turned[row][1] * m.r[column][1] +
             turned[row][2] * m.r[column][2];
    };
    const double xx = product(0, 0) + p.b_xx[i], xy = product(0, 1) + p.b_xy[i];
    const double xz = product(0, 2) + p.b_xz[i], yy = product(1, 1) + p.b_yy[i];
    const double yz = product(1, 2) + p.b_yz[i], zz = product(2, 2) + p.b_zz[i];

    // The inverse: cofactors by the determinant.
    const double c_xx = yy * zz - yz * yz, c_xy = xz * yz - xy * zz, c_xz = xy * yz - xz * yy;
    const double scale = 1 / (xx * c_xx + xy * c_xy + xz * c_xz);
    const double i_xx = scale * c_xx, i_xy = scale * c_xy, i_xz = scale * c_xz;
    const double i_yy = scale * (xx * zz - xz * xz), i_yz = scale * (xy * xz - xx * yz);
    const double i_zz = scale * (xx * yy - xy * xy);

    out->error[0][i] = ex;
    out->error[1][i] = ey;
    out->error[2][i] = ez;
    out->information[0][i] = i_xx;
    out->information[1][i] = i_xy;
    out->information[2][i] = i_xz;
    out->information[3][i] = i_yy;
    out->information[4][i] = i_yz;
    out->information[5][i] = i_zz;
    out->distance2[i] = ex * (i_xx * ex + i_xy * ey + i_xz * ez) + ey * (i_xy * ex + i_yy * ey + i_yz * ez) +
                        ez * (i_xz * ex + i_yz * ey + i_zz * ez);
  }
}

}  // namespace

PairColumns::PairColumns(const std::vector<PointPair>& pairs) : size_(pairs.size()), numbers_(all * size_) {
  for (std::size_t i = 0; i < size_; ++i) put(i, pairs[i]);
}

PairColumns::PairColumns(const std::vector<PointPair>& pairs, const std::vector<int>& indices)
    : size_(indices.size()), numbers_(all * size_) {
  for (std::size_t i = 0; i < size_; ++i) put(i, pairs[static_cast<std::size_t>(indices[i])]);
}

void PairColumns::put(std::size_t i, const PointPair& pair) {
  const auto set = [&](std::size_t column, double number) { numbers_[column * size_ + i] = number; };
  std::size_t upper = 0;
  for (int row = 0; row < 3; ++row) {
    set(points_a + static_cast<std::size_t>(row), pair.point_a[row]);
    set(points_b + static_cast<std::size_t>(row), pair.point_b[row]);
    for (int k = row; k < 3; ++k, ++upper) {
      set(covariances_a + upper, pair.covariance_a(row, k));
      set(covariances_b + upper, pair.covariance_b(row, k));
    }
  }
}

Eigen::Vector3d PairColumns::point_b(int i) const {
  return {column(points_b)[i], column(points_b + 1)[i], column(points_b + 2)[i]};
}

int PairColumns::measure(const Eigen::Isometry3d& T_a_b, int first, PairResiduals& residuals) const {
  const int count = std::min(size() - first, PairResiduals::most);
  const auto from = [&](std::size_t number) { return column(number) + first; };
  const PairNumbers numbers{from(0),  from(1),  from(2),  from(3),  from(4),  from(5),
                            from(6),  from(7),  from(8),  from(9),  from(10), from(11),
                            from(12), from(13), from(14), from(15), from(16), from(17)};
  Motion motion;
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) motion.r[row][k] = T_a_b.linear()(k, row);
    motion.t[row] = T_a_b.translation()[row];
  }
  measure_pairs(numbers, motion, count, &residuals);
  return count;
}

}  // namespace lcmslam
