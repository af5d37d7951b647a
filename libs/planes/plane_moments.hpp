#pragma once
// Planes by the moments of their points: sums that can be added, and the plane of least squares through them.

#include <Eigen/Dense>
#include <array>

namespace lcmslam {

/// normal . point + offset = 0; the normal is unit and looks towards where the plane was seen from.
struct PlaneEquation {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;  ///< m
  double distance(const Eigen::Vector3d& point) const { return normal.dot(point) + offset; }
};

/// A plane's own frame: origin at the points' mean, z the normal.
struct PlaneFit {
  PlaneEquation plane;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m
  double rms = 0;                                    ///< m, of the points' distances
  /// Of (tilt about axis, tilt about normal x axis, distance at the centre), rad and m; axis is the direction
  /// of greatest spread. In closed form: each point of deviation sigma tells its distance u a - v b + d, so
  /// the information is the sum of (u, v, 1)(u, v, 1)^T / sigma^2, and at the centre it is diagonal.
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
};

/// Sums over points: their number, x, y, z, xx, xy, xz, yy, yz, zz (m, m^2).
constexpr int sums_of_points = 10;

/// Depth cameras err along their rays. Where points are seen at a slant, least squares of their distances
/// would take that for a tilt, which no number of frames takes away; so the fit asks what is least compared
/// with what noise of such rays would give.
struct PlaneMoments {
  double weight = 0;  ///< of all points: their number times 1 / sigma^2, 1/m^2
  double points = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();      ///< weighted, m
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();  ///< weighted, m^2
  Eigen::Matrix3d rays = Eigen::Matrix3d::Zero();  ///< sum of r r^T of rays r = (x/z, y/z, 1); zero: unknown

  void add(const Eigen::Vector3d& point) {
    weight += 1;
    points += 1;
    sum += point;
    squares += point * point.transpose();
  }
  void add(const PlaneMoments& other) {
    weight += other.weight;
    points += other.points;
    sum += other.sum;
    squares += other.squares;
    rays += other.rays;
  }
  /// The same points in another frame.
  PlaneMoments moved(const Eigen::Isometry3d& T) const;
  /// Of points (of weight 1) in a small part of the image of a camera at the origin: with their ray, and the
  /// weight that depths of deviation `sigma` (m) have.
  PlaneMoments weighed(double sigma) const;

  /// Root mean square of the points' distances from a plane, m.
  double rms_from(const PlaneEquation& plane) const;

  /// `seen_from` (m) decides which way the normal looks. Needs points that are not on one line.
  PlaneFit fit(const Eigen::Vector3d& seen_from) const;
};

/// Of points, of weight 1, whose coordinates were summed from `place` (m) on.
PlaneMoments moments_about(const Eigen::Vector3d& place, const std::array<double, sums_of_points>& sums);

}  // namespace lcmslam
