#pragma once
// Trajectories seen from above and their errors over time, drawn into an image or as SVG.

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include <lcmslam/evaluation/trajectory.hpp>

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

/// CV_8UC3, BGR. One scale for both axes, a grid labelled in metres, a
/// scale bar, a legend above the plot; a disc marks each path's start, a square its end. Points that
/// are not finite interrupt a path. Throws std::invalid_argument when the image is smaller than
/// 320x240.
cv::Mat plot_paths(const std::vector<PlottedPath>& paths, const PlotSettings& settings = {});

/// The top view and, below it and half as high, errors over time.
struct EvaluationPlot {
  std::vector<PlottedPath> paths;   ///< x, y in m
  std::vector<PlottedPath> errors;  ///< time in s, error in m; drawn in their colours, without names
};
cv::Mat plot_evaluation(const EvaluationPlot& plot, const PlotSettings& settings = {});
std::string plot_evaluation_svg(const EvaluationPlot& plot, const PlotSettings& settings = {});

/// As PNG or SVG, by the name's end; std::invalid_argument for another one. The file is replaced whole or not
/// at all; std::runtime_error names it.
void write_plot(const std::filesystem::path& file, const EvaluationPlot& plot,
                const PlotSettings& settings = {});
/// CV_8UC3 as PNG, likewise.
void write_png(const std::filesystem::path& file, const cv::Mat& picture);

}  // namespace lcmslam
