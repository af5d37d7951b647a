#include <lcmslam/planes/plane_moments.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {

PlaneMoments PlaneMoments::moved(const Eigen::Isometry3d& T) const {
  const Eigen::Matrix3d& R = T.linear();
  const Eigen::Vector3d& t = T.translation();
  PlaneMoments result = *this;
  const Eigen::Vector3d turned = R * sum;
  result.sum = turned + weight * t;
  result.squares = R * squares * R.transpose() + turned * t.transpose() + t * turned.transpose() +
                   weight * t * t.transpose();
  return result;
}

PlaneMoments PlaneMoments::scaled(double factor) const {
  PlaneMoments result = *this;
  result.weight *= factor;
  result.sum *= factor;
  result.squares *= factor;
  return result;
}

PlaneFit PlaneMoments::fit(const Eigen::Vector3d& seen_from) const {
  PlaneFit result;
  result.centre = sum / weight;
  const Eigen::Matrix3d spread = squares / weight - result.centre * result.centre.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(spread);
  result.plane.normal = solver.eigenvectors().col(0).normalized();
  result.axis = solver.eigenvectors().col(2);
  if (result.plane.normal.dot(seen_from - result.centre) < 0) result.plane.normal = -result.plane.normal;
  result.plane.offset = -result.plane.normal.dot(result.centre);
  const Eigen::Vector3d& spreads = solver.eigenvalues();  // rising, m^2
  result.rms = std::sqrt(std::max(spreads[0], 0.0));
  // Tilting about the long axis moves points by their distance from it: the middle spread.
  result.variance = {1 / (weight * std::max(spreads[1], 1e-9)), 1 / (weight * std::max(spreads[2], 1e-9)),
                     1 / weight};
  return result;
}

}  // namespace lcmslam
