#pragma once
#include <ceres/problem.h>
#include <Eigen/Core>
#include <vector>

namespace lcmslam {

/// Covariance of the first blocks of a least-squares problem at its present values, in their order, all
/// others marginalised: landmarks (blocks of three, of which no residual has two) by Schur's complement,
/// the rest densely.
Eigen::MatrixXd marginal_covariance(ceres::Problem& problem, const std::vector<double*>& wanted,
                                    const std::vector<double*>& others,
                                    const std::vector<double*>& landmarks);

}  // namespace lcmslam
