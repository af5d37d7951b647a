#pragma once
// A coloured triangle mesh.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace lcmslam {

/// Vertices, normals and colours have the same length.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;                ///< m
  std::vector<Eigen::Vector3f> normals;                 ///< unit, towards free space
  std::vector<cv::Vec3b> colours;                       ///< BGR
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise as seen from free space
};

}  // namespace lcmslam
