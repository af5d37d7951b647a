#include <lcmslam/calibration/self/cost_functions.hpp>

#include <ceres/autodiff_cost_function.h>

namespace lcmslam {

using ceres::AutoDiffCostFunction;
using namespace residuals;

ceres::CostFunction* cost_of(const Reprojection& residual) {
  return new AutoDiffCostFunction<Reprojection, 2, keyframe_size, 3, 9, 1>(new Reprojection(residual));
}

ceres::CostFunction* cost_of(const SurfaceOfOwnCamera& residual) {
  return new AutoDiffCostFunction<SurfaceOfOwnCamera, 1, keyframe_size, 3, 6, 6, 1, 1, 1, 1>(
      new SurfaceOfOwnCamera(residual));
}

ceres::CostFunction* cost_of(const SurfaceOfColour& residual) {
  return new AutoDiffCostFunction<SurfaceOfColour, 1, keyframe_size, 3, 9, 6, 1, 1, 1, 1>(
      new SurfaceOfColour(residual));
}

ceres::CostFunction* cost_of(const ToldTurnRate& residual) {
  return new AutoDiffCostFunction<ToldTurnRate, 3, keyframe_size>(new ToldTurnRate(residual));
}

ceres::CostFunction* cost_of(const Aspect& residual) {
  return new AutoDiffCostFunction<Aspect, 1, 9>(new Aspect(residual));
}

ceres::CostFunction* cost_of(const Prior& residual, int block_size) {
  switch (block_size) {
    case 9:
      return new AutoDiffCostFunction<Prior, 1, 9>(new Prior(residual));
    case 6:
      return new AutoDiffCostFunction<Prior, 1, 6>(new Prior(residual));
    default:
      return new AutoDiffCostFunction<Prior, 1, 1>(new Prior(residual));
  }
}

}  // namespace lcmslam
