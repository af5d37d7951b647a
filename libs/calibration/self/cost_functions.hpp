#pragma once
// The residuals as Ceres takes them, compiled apart: their derivatives are most of the compiler's work.

#include <ceres/cost_function.h>

#include <lcmslam/calibration/self/residuals.hpp>

namespace lcmslam {

ceres::CostFunction* cost_of(const residuals::Reprojection& residual);  ///< pose, point, intrinsics, rows
/// pose, point, extrinsics, depth, a range curve's four numbers
ceres::CostFunction* cost_of(const residuals::SurfaceOfOwnCamera& residual);
/// pose, point, intrinsics, depth, a range curve's four numbers
ceres::CostFunction* cost_of(const residuals::SurfaceOfColour& residual);
ceres::CostFunction* cost_of(const residuals::ToldTurnRate& residual);
ceres::CostFunction* cost_of(const residuals::Aspect& residual);  ///< intrinsics
/// Of a block of 9, 6 or 1 numbers.
ceres::CostFunction* cost_of(const residuals::Prior& residual, int block_size);

}  // namespace lcmslam
