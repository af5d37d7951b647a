#pragma once
// Trajectories seen from above, drawn into an image.

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "evaluation/trajectory.hpp"

namespace lcmslam {

struct PlottedPath {
  std::string name;                       ///< for the legend (ASCII: OpenCV's font has no more)
  std::array<unsigned char, 3> colour{};  ///< R, G, B
  std::vector<Eigen::Vector2d> points;    ///< m, drawn to the right and upwards
};

struct PlotSettings {
  int width = 960;  ///< pixels
  int height = 720;
  std::string title;
};

/// The horizontal part (x to the right, y upwards) of a trajectory.
PlottedPath top_view(const std::string& name, const std::array<unsigned char, 3>& colour,
                     const Trajectory& trajectory);

/// Colours that are told apart by most eyes, also those that see no red or green (Okabe and Ito 2008).
std::array<unsigned char, 3> plot_colour(std::size_t index);

/// CV_8UC3, BGR (cv::imwrite makes the PNG). One scale for both axes, a grid labelled in metres, a
/// scale bar, a legend above the plot; a disc marks each path's start, a square its end. Points that
/// are not finite interrupt a path. Throws std::invalid_argument when the image is smaller than
/// 320x240.
cv::Mat plot_paths(const std::vector<PlottedPath>& paths, const PlotSettings& settings = {});

}  // namespace lcmslam
