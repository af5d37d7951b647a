#include <lcmslam/evaluation/trajectory_plot.hpp>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include <lcmslam/evaluation/plot_frame.hpp>
#include <lcmslam/files/atomic_file.hpp>

namespace lcmslam {
namespace {

constexpr double left_margin = 66, right_margin = 20, line_height = 22;  // pixels
constexpr double min_span = 0.1;  // m: a robot at rest has a picture too
const PlotColour black = {0, 0, 0}, grey = {110, 110, 110};

/// Shown with some room around it, one scale for both axes.
PlotBounds top_view_bounds(const std::vector<PlottedPath>& paths) {
  const auto bounds = bounds_of(paths);
  if (!bounds) return {{-0.5, -0.5}, {0.5, 0.5}};
  const double span = std::max(min_span, (bounds->high - bounds->low).maxCoeff());
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.05 * span);
  return {bounds->low - margin, bounds->high + margin};
}

/// From zero error to a bit above the largest.
PlotBounds error_bounds(const std::vector<PlottedPath>& errors) {
  const auto bounds = bounds_of(errors);
  if (!bounds) return {{0, 0}, {1, 1}};
  const double seconds = std::max(1e-3, bounds->high.x() - bounds->low.x());
  return {{bounds->low.x(), 0}, {bounds->low.x() + seconds, std::max(1e-6, 1.1 * bounds->high.y())}};
}

/// Names in rows that break at the right edge; returns the height that is free below.
double draw_legend(PlotSurface& surface, const std::vector<PlottedPath>& paths, double top, double right) {
  double x = left_margin;
  for (const PlottedPath& path : paths) {
    const double width = 28 + surface.text_width(path.name) + 22;
    if (x > left_margin && x + width > right) {
      x = left_margin;
      top += line_height;
    }
    surface.line({x, top + 9}, {x + 22, top + 9}, path.colour, 3);
    surface.text(path.name, {x + 28, top + 14}, black);
    x += width;
  }
  return paths.empty() ? top : top + line_height;
}

void draw_scale_bar(PlotSurface& surface, const PlotFrame& frame) {
  const double length = grid_step(70 / frame.pixels_per_unit());
  const double pixels = std::round(length * frame.pixels_per_unit());
  const cv::Point2d left(frame.box().x, frame.box().br().y + 36);
  for (const double x : {0.0, pixels})
    surface.line(left + cv::Point2d(x, -4), left + cv::Point2d(x, 4), black, 2);
  surface.line(left, left + cv::Point2d(pixels, 0), black, 2);
  surface.text(axis_number(length, length) + " m", left + cv::Point2d(pixels + 8, 5), black);
}

void draw_top_view(PlotSurface& surface, const std::vector<PlottedPath>& paths,
                   const PlotSettings& settings) {
  double top = 12;
  if (!settings.title.empty()) {
    surface.text(settings.title, {0.5 * settings.width, top + 14}, black, PlotSurface::Anchor::middle);
    top += line_height;
  }
  top = draw_legend(surface, paths, top, settings.width);
  const PlotFrame frame(cv::Rect2d(left_margin, top + 6, settings.width - left_margin - right_margin,
                                   settings.height - top - 6 - 52),
                        top_view_bounds(paths), true);
  frame.draw_grid(surface, {90, 90});
  for (const PlottedPath& path : paths) frame.draw_curve(surface, path);
  for (const PlottedPath& path : paths) frame.draw_ends(surface, path);
  draw_scale_bar(surface, frame);
  surface.text("x to the right, y upwards, m", {frame.box().br().x, frame.box().br().y + 40}, grey,
               PlotSurface::Anchor::right);
}

/// Below the top view, in `height` pixels from `top`.
void draw_errors(PlotSurface& surface, const std::vector<PlottedPath>& errors, double top, double height,
                 double width) {
  const PlotFrame frame(
      cv::Rect2d(left_margin, top + 26, width - left_margin - right_margin, height - 26 - 46),
      error_bounds(errors), false);
  surface.text("translation error after alignment, m", {left_margin, top + 16}, black);
  frame.draw_grid(surface, {90, 40});
  for (const PlottedPath& curve : errors) frame.draw_curve(surface, curve);
  surface.text("time, s", {frame.box().br().x, frame.box().br().y + 38}, grey, PlotSurface::Anchor::right);
}

void check(const PlotSettings& settings) {
  if (settings.width < 320 || settings.height < 240) {
    throw std::invalid_argument("plot of " + std::to_string(settings.width) + "x" +
                                std::to_string(settings.height) + " pixels; expected at least 320x240");
  }
}

int error_height(const PlotSettings& settings) {
  return std::max(160, settings.height / 2);
}

void draw(PlotSurface& surface, const EvaluationPlot& plot, const PlotSettings& settings) {
  draw_top_view(surface, plot.paths, settings);
  draw_errors(surface, plot.errors, settings.height, error_height(settings), settings.width);
}

}  // namespace

PlottedPath top_view(const std::string& name, const std::array<unsigned char, 3>& colour,
                     const Trajectory& trajectory) {
  PlottedPath path{name, colour, {}};
  path.points.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) path.points.push_back(pose.T_world_body.translation().head<2>());
  return path;
}

std::array<unsigned char, 3> plot_colour(std::size_t index) {
  constexpr std::array<std::array<unsigned char, 3>, 7> palette = {{{0, 0, 0},
                                                                    {213, 94, 0},
                                                                    {0, 114, 178},
                                                                    {0, 158, 115},
                                                                    {204, 121, 167},
                                                                    {230, 159, 0},
                                                                    {86, 180, 233}}};
  return palette[index % palette.size()];
}

cv::Mat plot_paths(const std::vector<PlottedPath>& paths, const PlotSettings& settings) {
  check(settings);
  RasterSurface surface(settings.width, settings.height);
  draw_top_view(surface, paths, settings);
  return surface.image();
}

cv::Mat plot_evaluation(const EvaluationPlot& plot, const PlotSettings& settings) {
  check(settings);
  RasterSurface surface(settings.width, settings.height + error_height(settings));
  draw(surface, plot, settings);
  return surface.image();
}

std::string plot_evaluation_svg(const EvaluationPlot& plot, const PlotSettings& settings) {
  check(settings);
  SvgSurface surface(settings.width, settings.height + error_height(settings));
  draw(surface, plot, settings);
  return surface.document();
}

void write_png(const std::filesystem::path& file, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", picture, bytes);
  write_atomically(file, std::string(bytes.begin(), bytes.end()));
}

void write_plot(const std::filesystem::path& file, const EvaluationPlot& plot, const PlotSettings& settings) {
  const std::string kind = file.extension().string();
  if (kind == ".svg")
    write_atomically(file, plot_evaluation_svg(plot, settings));
  else if (kind == ".png")
    write_png(file, plot_evaluation(plot, settings));
  else
    throw std::invalid_argument(file.string() + ": a plot's name must end in .png or .svg");
}

}  // namespace lcmslam
