#include <lcmslam/planes/bent_plane.hpp>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace lcmslam {
namespace {

constexpr Eigen::Index no_part = -1;
constexpr int least_samples = 5;      // of a part
constexpr int rounds = 2;             // of looking for steps, then for the plane beside them
constexpr double step_sigmas = 2;     // beyond which it is a step
constexpr double most_step = 0.02;    // m, across a cut
constexpr double farthest_off = 0.1;  // m, a part from the plane

/// What the samples of each cell say together; rows are parts, in the order of their cells.
struct Parts {
  std::vector<int> cells;
  Eigen::MatrixXd places, knots, plane;          // m; h; p
  Eigen::VectorXd residuals, variances, slants;  // m, m^2

  Eigen::Index size() const { return static_cast<Eigen::Index>(cells.size()); }
  Eigen::Index at(int cell) const {
    const auto found = std::lower_bound(cells.begin(), cells.end(), cell);
    return found == cells.end() || *found != cell ? no_part : found - cells.begin();
  }
};

std::vector<int> cells_with_enough(const std::vector<PlaneSample>& samples) {
  std::vector<int> all, enough;
  for (const PlaneSample& s : samples) all.push_back(s.cell);
  std::sort(all.begin(), all.end());
  for (auto i = all.begin(); i != all.end();) {
    const auto end = std::upper_bound(i, all.end(), *i);
    if (end - i >= least_samples) enough.push_back(*i);
    i = end;
  }
  return enough;
}

Parts parts_of(const std::vector<PlaneSample>& samples, Eigen::Index knots) {
  Parts parts;
  parts.cells = cells_with_enough(samples);
  const Eigen::Index n = parts.size();
  parts.places.setZero(n, 3);
  parts.knots.setZero(n, knots);
  parts.plane.setZero(n, 3);
  parts.residuals = parts.variances = parts.slants = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(n);
  for (const PlaneSample& s : samples) {
    const Eigen::Index i = parts.at(s.cell);
    if (i == no_part) continue;
    parts.places.row(i) += s.place.transpose();
    parts.knots(i, s.knot) += 1 - s.beyond;
    parts.knots(i, s.knot + 1) += s.beyond;
    parts.plane.row(i) += s.plane.transpose();
    parts.residuals(i) += s.residual;
    parts.variances(i) += s.variance;
    parts.slants(i) += s.slant;
    ++count(i);
  }
  const Eigen::VectorXd share = count.cwiseInverse();
  for (Eigen::MatrixXd* sum : {&parts.places, &parts.knots, &parts.plane}) *sum = share.asDiagonal() * *sum;
  for (Eigen::VectorXd* sum : {&parts.residuals, &parts.variances, &parts.slants})
    sum->array() *= share.array();
  parts.variances.array() *= share.array();
  return parts;
}

/// The walk of heights over the raster.
class Walk {
 public:
  Walk(const Parts& parts, int columns, double unevenness)
      : next_(parts.cells.size()), variance_(parts.cells.size()), cut_(parts.cells.size(), {false, false}) {
    for (Eigen::Index i = 0; i < parts.size(); ++i) {
      const int cell = parts.cells[index(i)];
      next_[index(i)] = {(cell + 1) % columns == 0 ? no_part : parts.at(cell + 1), parts.at(cell + columns)};
      for (std::size_t way : {0U, 1U})
        if (const Eigen::Index to = next_[index(i)][way]; to != no_part)
          variance_[index(i)][way] =
              unevenness * unevenness * (parts.places.row(i) - parts.places.row(to)).norm();
    }
  }

  /// Cuts it where is_step(one, another) holds for neighbours, or for those one part apart: an edge may lie
  /// within a part.
  template <typename IsStep>
  void cut(IsStep is_step) {
    for (auto& cut : cut_) cut = {false, false};
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(next_.size()); ++i)
      for (std::size_t way : {0U, 1U}) {
        const Eigen::Index middle = next_[index(i)][way];
        if (middle == no_part) continue;
        const Eigen::Index far = next_[index(middle)][way];
        if (is_step(i, middle)) cut_[index(i)][way] = true;
        if (far != no_part && is_step(i, far)) cut_[index(i)][way] = cut_[index(middle)][way] = true;
      }
  }

  /// Information of the heights, 1/m^2, of which `measured` is told beside it.
  Eigen::SparseMatrix<double> information(const Eigen::VectorXd& measured) const {
    const Eigen::Index n = measured.size();
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index i = 0; i < n; ++i) {
      entries.emplace_back(i, i, measured(i) + 1 / (farthest_off * farthest_off));
      for (std::size_t way : {0U, 1U}) {
        const Eigen::Index to = next_[index(i)][way];
        if (to == no_part) continue;
        const double tie = 1 / (variance_[index(i)][way] + (cut_[index(i)][way] ? most_step * most_step : 0));
        entries.emplace_back(i, i, tie);
        entries.emplace_back(to, to, tie);
        entries.emplace_back(i, to, -tie);
        entries.emplace_back(to, i, -tie);
      }
    }
    Eigen::SparseMatrix<double> A(n, n);
    A.setFromTriplets(entries.begin(), entries.end());
    return A;
  }

 private:
  static std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

  std::vector<std::array<Eigen::Index, 2>> next_;  // to the right, below
  std::vector<std::array<double, 2>> variance_;    // m^2, of a step there
  std::vector<std::array<bool, 2>> cut_;
};

/// Normal equations of (plane's tilts and distance, w less what is known of it), heights eliminated.
struct Reduced {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  double squares;  // of the measurements, as far as heights leave them
};

Reduced without_heights(const Parts& parts, const Eigen::VectorXd& y, const Walk& walk) {
  Eigen::MatrixXd C(parts.size(), 3 + parts.knots.cols());
  C << parts.plane, parts.knots;
  const Eigen::VectorXd weight = parts.variances.cwiseInverse(), rise = parts.slants.cwiseInverse();
  const Eigen::MatrixXd WC = weight.asDiagonal() * C, RWC = rise.asDiagonal() * WC;
  const Eigen::VectorXd Wy = weight.cwiseProduct(y), RWy = rise.cwiseProduct(Wy);
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> heights(
      walk.information(weight.cwiseProduct(rise.cwiseProduct(rise))));
  const Eigen::MatrixXd of_C = heights.solve(RWC);
  const Eigen::VectorXd of_y = heights.solve(RWy);
  return {C.transpose() * WC - RWC.transpose() * of_C, C.transpose() * Wy - RWC.transpose() * of_y,
          y.dot(Wy) - RWy.dot(of_y)};
}

}  // namespace

ToldOfCurve told_by_plane(const std::vector<PlaneSample>& samples, int columns, const RangeCurve& known,
                          double unevenness) {
  const Eigen::Index knots = known.mean.size();
  const Parts parts = parts_of(samples, knots);
  ToldOfCurve told{Eigen::MatrixXd::Zero(knots, knots), Eigen::VectorXd::Zero(knots), 0};
  if (parts.size() < 4) return told;  // three are the plane's own
  const Eigen::VectorXd y = parts.residuals - parts.knots * known.mean;
  Eigen::MatrixXd prior = Eigen::MatrixXd::Identity(3 + knots, 3 + knots);  // 1 rad, 1 m: anything
  prior.bottomRightCorner(knots, knots) = known.information;

  // What is unknown of w, and noise, make of heights.
  const Eigen::MatrixXd unknown =
      parts.slants.asDiagonal() * parts.knots * known.covariance.llt().matrixL().toDenseMatrix();
  const Eigen::VectorXd noise = parts.variances.cwiseProduct(parts.slants.cwiseAbs2());
  Walk walk(parts, columns, unevenness);
  Reduced reduced = without_heights(parts, y, walk);
  Eigen::VectorXd found = (reduced.A + prior).llt().solve(reduced.b);
  for (int round = 0; round < rounds; ++round) {
    const Eigen::VectorXd heights = parts.slants.cwiseProduct(y - parts.plane * found.head<3>());
    walk.cut([&](Eigen::Index a, Eigen::Index b) {
      const double variance = noise(a) + noise(b) + (unknown.row(a) - unknown.row(b)).squaredNorm();
      return std::abs(heights(a) - heights(b)) > step_sigmas * std::sqrt(variance);
    });
    reduced = without_heights(parts, y, walk);
    found = (reduced.A + prior).llt().solve(reduced.b);
  }
  const Eigen::MatrixXd across = reduced.A.topRightCorner(3, knots);
  const Eigen::LLT<Eigen::Matrix3d> own(reduced.A.topLeftCorner<3, 3>() + Eigen::Matrix3d::Identity());
  told.information = reduced.A.bottomRightCorner(knots, knots) - across.transpose() * own.solve(across);
  told.vector = reduced.b.tail(knots) - across.transpose() * own.solve(reduced.b.head<3>()) +
                told.information * known.mean;
  told.misfit = (reduced.squares - reduced.b.dot(found)) / static_cast<double>(parts.size());
  return told;
}

}  // namespace lcmslam
