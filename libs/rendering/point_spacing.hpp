#pragma once
// How far apart the points of a surface lie around each of them: near the camera's path they lie densely, far
// from it sparsely, and a picture that is to be sharp here and closed there must know.

#include <vector>

#include <Eigen/Core>

namespace lcmslam {

/// m, for each point (m); from `finest` to `coarsest`, of the density in a window of 8 `finest`, or of the
/// next larger one that has a few points. Lonely points are no surface that is to be closed, and get
/// `finest`.
std::vector<float> point_spacing(const std::vector<Eigen::Vector3f>& points, double finest, double coarsest);

}  // namespace lcmslam
