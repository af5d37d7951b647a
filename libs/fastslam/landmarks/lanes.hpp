#pragma once
// Four doubles side by side, and the small vectors and matrices made of them: the arithmetic of four
// particles at once. Every lane computes what a double would, no lane looks at another: so it does not matter
// which particles go together, and AVX2 and SSE2 give the same bits. All of it is inlined into kernels
// (LCMSLAM_VECTORISED), which are compiled for both.

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

#define LCMSLAM_LANES __attribute__((always_inline)) inline
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"  // how AVX vectors are passed: here they never are
#endif

namespace lcmslam {

constexpr int lane_count = 4;
using Lanes = double __attribute__((vector_size(32), aligned(32)));
using LaneMask = std::int64_t __attribute__((vector_size(32), aligned(32)));

LCMSLAM_LANES Lanes all_lanes(double value) {
  return Lanes{value, value, value, value};
}
/// What `value(lane)` says of each.
template <class Value>
LCMSLAM_LANES Lanes each_lane(const Value& value) {
  return Lanes{value(0), value(1), value(2), value(3)};
}
/// a where the comparison holds (-1, otherwise 0), b elsewhere.
LCMSLAM_LANES Lanes chosen(const LaneMask& holds, const Lanes& a, const Lanes& b) {
  return (Lanes)((holds & (LaneMask)a) | (~holds & (LaneMask)b));
}
LCMSLAM_LANES Lanes larger(const Lanes& a, const Lanes& b) {
  return chosen(a > b, a, b);
}
LCMSLAM_LANES Lanes square_root(const Lanes& a) {
  return each_lane([&](int lane) { return std::sqrt(a[lane]); });
}

struct LaneVector {
  Lanes x, y, z;
};

/// 3x3; its lower triangle.
struct LaneSymmetric {
  Lanes xx, yx, zx, yy, zy, zz;
};

/// 3x3, by columns.
struct LaneMatrix {
  LaneVector x, y, z;
};

struct LanePose {
  LaneMatrix R;
  LaneVector t;
};

template <class Value>
LCMSLAM_LANES LaneVector each_lane_vector(const Value& value) {
  return {each_lane([&](int lane) { return value(lane)[0]; }),
          each_lane([&](int lane) { return value(lane)[1]; }),
          each_lane([&](int lane) { return value(lane)[2]; })};
}
LCMSLAM_LANES LanePose each_lane_pose(const Eigen::Isometry3d* T) {
  const auto column = [T](int c) {
    return each_lane_vector([T, c](int lane) { return T[lane].matrix().data() + 4 * c; });
  };
  return {{column(0), column(1), column(2)}, column(3)};
}
LCMSLAM_LANES LaneVector all_lanes(const Eigen::Vector3d& v) {
  return {all_lanes(v[0]), all_lanes(v[1]), all_lanes(v[2])};
}
LCMSLAM_LANES LaneSymmetric all_lanes(const Eigen::Matrix3d& P) {
  return {all_lanes(P(0, 0)), all_lanes(P(1, 0)), all_lanes(P(2, 0)),
          all_lanes(P(1, 1)), all_lanes(P(2, 1)), all_lanes(P(2, 2))};
}

LCMSLAM_LANES LaneVector operator+(const LaneVector& a, const LaneVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
LCMSLAM_LANES LaneVector operator-(const LaneVector& a, const LaneVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
LCMSLAM_LANES LaneVector operator*(const Lanes& s, const LaneVector& a) {
  return {s * a.x, s * a.y, s * a.z};
}
LCMSLAM_LANES Lanes dot(const LaneVector& a, const LaneVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
LCMSLAM_LANES LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

LCMSLAM_LANES LaneSymmetric operator+(const LaneSymmetric& a, const LaneSymmetric& b) {
  return {a.xx + b.xx, a.yx + b.yx, a.zx + b.zx, a.yy + b.yy, a.zy + b.zy, a.zz + b.zz};
}
LCMSLAM_LANES LaneSymmetric operator*(const Lanes& s, const LaneSymmetric& a) {
  return {s * a.xx, s * a.yx, s * a.zx, s * a.yy, s * a.zy, s * a.zz};
}
/// Columns of a symmetric matrix.
LCMSLAM_LANES LaneMatrix columns(const LaneSymmetric& a) {
  return {{a.xx, a.yx, a.zx}, {a.yx, a.yy, a.zy}, {a.zx, a.zy, a.zz}};
}
LCMSLAM_LANES LaneVector operator*(const LaneMatrix& A, const LaneVector& v) {
  return v.x * A.x + v.y * A.y + v.z * A.z;
}
LCMSLAM_LANES LaneVector operator*(const LaneSymmetric& A, const LaneVector& v) {
  return columns(A) * v;
}
LCMSLAM_LANES LaneMatrix operator*(const LaneMatrix& A, const LaneMatrix& B) {
  return {A * B.x, A * B.y, A * B.z};
}
LCMSLAM_LANES LaneMatrix transposed(const LaneMatrix& A) {
  return {{A.x.x, A.y.x, A.z.x}, {A.x.y, A.y.y, A.z.y}, {A.x.z, A.y.z, A.z.z}};
}
/// A B where the product is known to be symmetric.
LCMSLAM_LANES LaneSymmetric symmetric_product(const LaneMatrix& A, const LaneMatrix& B) {
  const LaneMatrix rows = transposed(A);
  return {dot(rows.x, B.x), dot(rows.y, B.x), dot(rows.z, B.x),
          dot(rows.y, B.y), dot(rows.z, B.y), dot(rows.z, B.z)};
}
/// A B A^T.
LCMSLAM_LANES LaneSymmetric sandwiched(const LaneMatrix& A, const LaneSymmetric& B) {
  return symmetric_product(A * columns(B), transposed(A));
}

struct LaneInverse {
  LaneSymmetric inverse;
  Lanes determinant;
};

/// By cofactors. A singular matrix gives what division by zero gives.
LCMSLAM_LANES LaneInverse inverted(const LaneSymmetric& S) {
  const Lanes A = S.yy * S.zz - S.zy * S.zy, B = S.zx * S.zy - S.yx * S.zz, C = S.yx * S.zy - S.zx * S.yy;
  const Lanes determinant = S.xx * A + S.yx * B + S.zx * C;
  const LaneSymmetric cofactors{
      A, B, C, S.xx * S.zz - S.zx * S.zx, S.yx * S.zx - S.xx * S.zy, S.xx * S.yy - S.yx * S.yx};
  return {1. / determinant * cofactors, determinant};
}

/// L with A = L L^T of small symmetric matrices; a lane whose matrix is not positive definite gets values
/// that are not finite. Compare SmallCholesky.
template <std::size_t N>
class LaneCholesky {
 public:
  struct Vector {
    Lanes lanes[N];
    LCMSLAM_LANES Lanes& operator[](std::size_t i) { return lanes[i]; }
    LCMSLAM_LANES const Lanes& operator[](std::size_t i) const { return lanes[i]; }
  };
  struct Matrix {
    Vector rows[N];
    LCMSLAM_LANES Vector& operator[](std::size_t i) { return rows[i]; }
    LCMSLAM_LANES const Vector& operator[](std::size_t i) const { return rows[i]; }
  };

  /// Reads A's lower triangle.
  LCMSLAM_LANES void factor(const Matrix& A) {
    for (std::size_t j = 0; j < N; ++j) {
      Lanes pivot = A[j][j];
      for (std::size_t k = 0; k < j; ++k) pivot -= L_[j][k] * L_[j][k];
      L_[j][j] = square_root(pivot);
      inverse_[j] = 1. / L_[j][j];
      for (std::size_t i = j + 1; i < N; ++i) {
        Lanes sum = A[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= L_[i][k] * L_[j][k];
        L_[i][j] = sum * inverse_[j];
      }
    }
  }
  /// v becomes L^-T v.
  LCMSLAM_LANES void solve_upper(Vector& v) const {
    for (std::size_t i = N; i-- > 0;) {
      for (std::size_t k = i + 1; k < N; ++k) v[i] -= L_[k][i] * v[k];
      v[i] *= inverse_[i];
    }
  }
  /// v becomes A^-1 v.
  LCMSLAM_LANES void solve(Vector& v) const {
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t k = 0; k < i; ++k) v[i] -= L_[i][k] * v[k];
      v[i] *= inverse_[i];
    }
    solve_upper(v);
  }
  /// log |A|^1/2 of one lane.
  double half_log_determinant(int lane) const {
    double product = 1;
    for (std::size_t i = 0; i < N; ++i) product *= L_[i][i][lane];
    return std::log(product);
  }

 private:
  Matrix L_;  // above the diagonal undefined
  Vector inverse_;
};

}  // namespace lcmslam

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
