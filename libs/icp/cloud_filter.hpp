#pragma once
// Which measured points may enter registration and map. ToF and structured-light cameras invent
// points at depth edges (mixed or flying pixels), and measure badly at grazing incidence.

#include "icp/cloud.hpp"

namespace lcmslam {

struct CloudFilterSettings {
  double min_range = 0.3;      ///< m, distance from the camera
  double max_range = 6.0;      ///< m
  double max_incidence = 1.4;  ///< rad between the viewing ray and the normal
  double max_sigma = 0.15;     ///< m
};

/// Points of a cloud in its camera's frame that are finite, have a normal, and keep the limits.
ColouredCloud usable_points(const ColouredCloud& cloud, const CloudFilterSettings& settings = {});
Cloud usable_points(const Cloud& cloud, const CloudFilterSettings& settings = {});

struct JumpEdgeSettings {
  double noise_sigmas = 4;     ///< a step within the noise is no edge
  double max_incidence = 1.4;  ///< rad; surfaces flatter to the ray than this count as edges
  int min_neighbours = 2;      ///< of the four, that continue the surface; fewer: the point goes
};

/// Sets points of an organised image to NaN that hang between surfaces. Two neighbours belong to one
/// surface when their range differs by no more than the distance between their rays at that range
/// times tan(max_incidence) plus the noise: the limit scales with pixel pitch and noise, so that it
/// holds for any resolution. `points` CV_32FC3 (camera frame, m), `sigma` CV_32FC1 (m, may be empty).
/// Only every `step`-th row and column is judged (and removed): what a thinned cloud will use.
/// Returns how many were removed. Throws std::invalid_argument for other types or sizes.
int remove_jump_edges(cv::Mat& points, const cv::Mat& sigma, const JumpEdgeSettings& settings = {},
                      int step = 1);

}  // namespace lcmslam
