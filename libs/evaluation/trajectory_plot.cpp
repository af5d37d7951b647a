#include "evaluation/trajectory_plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "evaluation/table.hpp"

namespace lcmslam {
namespace {

constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr double min_span = 0.1;  // m: a robot at rest has a picture too
constexpr double font_scale = 0.5;
constexpr int line_height = 22;  // pixels
constexpr int sub_pixel_bits = 4;
const cv::Scalar white(255, 255, 255), black(0, 0, 0), grid_colour(228, 228, 228), grey(110, 110, 110);

struct Bounds {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
};

// All points with some room around them.
Bounds bounds_of(const std::vector<PlottedPath>& paths) {
  Bounds bounds;
  for (const PlottedPath& path : paths) {
    for (const Eigen::Vector2d& point : path.points) {
      if (!point.allFinite()) continue;
      bounds.low = bounds.low.cwiseMin(point);
      bounds.high = bounds.high.cwiseMax(point);
    }
  }
  if (!(bounds.low.x() <= bounds.high.x())) return {{-0.5, -0.5}, {0.5, 0.5}};
  const double span = std::max(min_span, (bounds.high - bounds.low).maxCoeff());
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.05 * span);
  return {bounds.low - margin, bounds.high + margin};
}

// 1, 2 or 5 times a power of ten, at least `value`.
double round_step(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= value * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::string metres(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 6);
  return fixed_number(std::abs(value) < 1e-9 ? 0 : value, decimals);
}

cv::Scalar bgr(const std::array<unsigned char, 3>& colour) {
  return {double(colour[2]), double(colour[1]), double(colour[0])};
}

int text_width(const std::string& text) {
  int baseline = 0;
  return cv::getTextSize(text, font, font_scale, 1, &baseline).width;
}

class Canvas {
 public:
  Canvas(const std::vector<PlottedPath>& paths, const PlotSettings& settings)
      : image_(settings.height, settings.width, CV_8UC3, white) {
    int top = 12;
    if (!settings.title.empty()) {
      write(settings.title, {(settings.width - text_width(settings.title)) / 2, top + 14}, black);
      top += line_height;
    }
    top = draw_legend(paths, top);
    frame_ = cv::Rect(66, top + 6, settings.width - 66 - 20, settings.height - top - 6 - 52);
    fit(bounds_of(paths));
  }

  void draw_grid() {
    const double step = round_step(90 / pixels_per_metre_);
    const Eigen::Vector2d low = to_world(cv::Point(frame_.x, frame_.y + frame_.height));
    const Eigen::Vector2d high = to_world(cv::Point(frame_.x + frame_.width, frame_.y));
    for (double x = std::ceil(low.x() / step) * step; x <= high.x(); x += step) {
      const int u = cvRound(to_pixel({x, 0}).x);
      cv::line(image_, {u, frame_.y}, {u, frame_.y + frame_.height}, grid_colour);
      const std::string label = metres(x, step);
      write(label, {u - text_width(label) / 2, frame_.y + frame_.height + 18}, grey);
    }
    for (double y = std::ceil(low.y() / step) * step; y <= high.y(); y += step) {
      const int v = cvRound(to_pixel({0, y}).y);
      cv::line(image_, {frame_.x, v}, {frame_.x + frame_.width, v}, grid_colour);
      const std::string label = metres(y, step);
      write(label, {frame_.x - 8 - text_width(label), v + 5}, grey);
    }
    cv::rectangle(image_, frame_, grey);
    const std::string axes = "x to the right, y upwards, m";
    write(axes, {frame_.x + frame_.width - text_width(axes), frame_.y + frame_.height + 40}, grey);
  }

  void draw_path(const PlottedPath& path) {
    std::vector<cv::Point> run;
    const auto finish = [&] {
      if (run.size() > 1) cv::polylines(image_, run, false, bgr(path.colour), 2, cv::LINE_AA, sub_pixel_bits);
      run.clear();
    };
    for (const Eigen::Vector2d& point : path.points) {
      if (!point.allFinite()) {
        finish();
        continue;
      }
      const cv::Point2d p = to_pixel(point);
      constexpr double factor = 1 << sub_pixel_bits;
      run.emplace_back(cvRound(p.x * factor), cvRound(p.y * factor));
    }
    finish();
  }

  void draw_ends(const PlottedPath& path) {
    const auto finite = [](const Eigen::Vector2d& p) { return p.allFinite(); };
    const auto first = std::find_if(path.points.begin(), path.points.end(), finite);
    const auto last = std::find_if(path.points.rbegin(), path.points.rend(), finite);
    if (first == path.points.end()) return;
    const cv::Point start = to_pixel(*first), end = to_pixel(*last);
    cv::circle(image_, start, 6, white, cv::FILLED, cv::LINE_AA);
    cv::circle(image_, start, 5, bgr(path.colour), cv::FILLED, cv::LINE_AA);
    cv::rectangle(image_, end - cv::Point(6, 6), end + cv::Point(6, 6), white, cv::FILLED);
    cv::rectangle(image_, end - cv::Point(5, 5), end + cv::Point(5, 5), bgr(path.colour), cv::FILLED);
  }

  void draw_scale_bar() {
    const double length = round_step(70 / pixels_per_metre_);
    const int pixels = cvRound(length * pixels_per_metre_);
    const std::string label = metres(length, length) + " m";
    const cv::Point left(frame_.x, frame_.y + frame_.height + 36);
    for (const int x : {0, pixels})
      cv::line(image_, left + cv::Point(x, -4), left + cv::Point(x, 4), black, 2);
    cv::line(image_, left, left + cv::Point(pixels, 0), black, 2);
    write(label, left + cv::Point(pixels + 8, 5), black);
  }

  cv::Mat image() const { return image_; }

 private:
  // Names in rows that break at the image's edge; returns the height that is free below.
  int draw_legend(const std::vector<PlottedPath>& paths, int top) {
    int x = 66;
    for (const PlottedPath& path : paths) {
      const int width = 28 + text_width(path.name) + 22;
      if (x > 66 && x + width > image_.cols) {
        x = 66;
        top += line_height;
      }
      cv::line(image_, {x, top + 9}, {x + 22, top + 9}, bgr(path.colour), 3);
      write(path.name, {x + 28, top + 14}, black);
      x += width;
    }
    return paths.empty() ? top : top + line_height;
  }

  void fit(const Bounds& bounds) {
    const Eigen::Vector2d size = bounds.high - bounds.low;
    pixels_per_metre_ = std::min(frame_.width / size.x(), frame_.height / size.y());
    centre_ = 0.5 * (bounds.low + bounds.high);
  }

  cv::Point2d middle() const { return {frame_.x + 0.5 * frame_.width, frame_.y + 0.5 * frame_.height}; }
  cv::Point2d to_pixel(const Eigen::Vector2d& p) const {
    return middle() + pixels_per_metre_ * cv::Point2d(p.x() - centre_.x(), centre_.y() - p.y());
  }
  Eigen::Vector2d to_world(const cv::Point2d& p) const {
    const cv::Point2d d = (p - middle()) / pixels_per_metre_;
    return {centre_.x() + d.x, centre_.y() - d.y};
  }
  void write(const std::string& text, const cv::Point& left_bottom, const cv::Scalar& colour) {
    cv::putText(image_, text, left_bottom, font, font_scale, colour, 1, cv::LINE_AA);
  }

  cv::Mat image_;
  cv::Rect frame_;  // of the plot
  double pixels_per_metre_ = 1;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
};

}  // namespace

PlottedPath top_view(const std::string& name, const std::array<unsigned char, 3>& colour,
                     const Trajectory& trajectory) {
  PlottedPath path{name, colour, {}};
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
  if (settings.width < 320 || settings.height < 240) {
    throw std::invalid_argument("plot of " + std::to_string(settings.width) + "x" +
                                std::to_string(settings.height) + " pixels; expected at least 320x240");
  }
  Canvas canvas(paths, settings);
  canvas.draw_grid();
  for (const PlottedPath& path : paths) canvas.draw_path(path);
  for (const PlottedPath& path : paths) canvas.draw_ends(path);
  canvas.draw_scale_bar();
  return canvas.image();
}

}  // namespace lcmslam
