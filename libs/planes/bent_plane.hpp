#pragma once
// What one look at a plane tells of a depth camera's error by range, however even the plane is.
//
// The error w is a function of the range alone; what a floor is uneven by is a function of the place. With s
// the height over the plane, parts of the image measure the distance along the ray from it:
//
//   m = h w + p (dn, dd) + s / n . u + noise        (see RangeError; h: weights of the knots of w)
//
// From a part to its neighbours s is a random walk. Where heights step by more than noise, walk and what is
// still unknown of w explain, as at a carpet's edge, the walk is cut: what lies on both sides tells of w,
// what is between them does not.

#include <Eigen/Core>
#include <vector>

namespace lcmslam {

/// A pixel of the plane.
struct PlaneSample {
  int cell;               ///< of the raster of parts that it belongs to: row * columns + column
  Eigen::Index knot;      ///< the last one at or before its range
  double beyond;          ///< 0..1 of the way to the next
  double residual;        ///< m, along the ray
  double variance;        ///< m^2
  double slant;           ///< n . u
  Eigen::Vector3d place;  ///< m
  Eigen::Vector3d plane;  ///< p: by what the plane's two tilts and its distance change the residual
};

/// w at the knots, as far as it is known.
struct RangeCurve {
  Eigen::VectorXd mean;                     ///< m
  Eigen::MatrixXd covariance, information;  ///< m^2, 1/m^2: each the other's inverse
};

struct ToldOfCurve {
  Eigen::MatrixXd information;  ///< 1/m^2
  Eigen::VectorXd vector;       ///< 1/m: information times what it says that w is
  double misfit = 0;            ///< to what was known: mean square over its expectation
};

/// `columns`: of the raster; `unevenness`: m of height after a metre of the walk. Less than four parts tell
/// nothing.
ToldOfCurve told_by_plane(const std::vector<PlaneSample>& samples, int columns, const RangeCurve& known,
                          double unevenness);

}  // namespace lcmslam
