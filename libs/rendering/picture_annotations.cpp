#include <lcmslam/rendering/picture_annotations.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr int fraction_bits = 4;  // OpenCV's sub-pixel drawing

cv::Point sub_pixel(const Eigen::Vector3d& pixel) {
  constexpr double far = 1e5;  // keeps OpenCV's fixed-point arithmetic from overflowing
  constexpr double one = 1 << fraction_bits;
  return {static_cast<int>(std::lround(std::clamp(pixel.x(), -far, far) * one)),
          static_cast<int>(std::lround(std::clamp(pixel.y(), -far, far) * one))};
}

int pixels(double length) {
  return std::max(1, static_cast<int>(std::lround(length)));
}

std::string metres(double value, double step) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", step < 0.1 ? 2 : step < 1 ? 1 : 0, value + 0.0);
  return text;
}

cv::Rect rectangle_of(const ViewFrame& frame) {
  return {cvRound(frame.left), cvRound(frame.top), cvRound(frame.width), cvRound(frame.height)};
}

/// Visits the grid lines of one world axis (0: x, 1: y) inside the frame with their pixel and value.
template <class Visit>
void for_ticks(const ViewCamera& camera, const ViewFrame& frame, int axis, double step, const Visit& visit) {
  const Eigen::Isometry3d T_world_camera = camera.T_camera_world.inverse();
  const auto world = [&](double column, double row) {
    const Eigen::Vector3d in_camera((column - camera.cx) / camera.scale, (row - camera.cy) / camera.scale, 0);
    return (T_world_camera * in_camera)[axis];
  };
  const double a = world(frame.left, frame.top),
               b = world(frame.left + frame.width, frame.top + frame.height);
  const double low = std::min(a, b), high = std::max(a, b);
  for (double k = std::ceil(low / step); k * step <= high; ++k) {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    point[axis] = k * step;
    visit(camera.project(point)[axis], k * step);
  }
}

double grid_step(const ViewCamera& camera, const PictureStyle& style) {
  return round_step(100 * style.unit / camera.scale);
}

void draw_segment(cv::Mat& picture, const ViewCamera& camera, const Eigen::Vector3d& from,
                  const Eigen::Vector3d& to, const cv::Scalar& colour, int thickness) {
  Eigen::Vector3d a = camera.T_camera_world * from, b = camera.T_camera_world * to;
  if (!camera.orthographic) {  // cut off what lies behind the viewer
    constexpr double near = 0.1;
    if (a.z() < near && b.z() < near) return;
    if (a.z() < near) a = b + (a - b) * ((b.z() - near) / (b.z() - a.z()));
    if (b.z() < near) b = a + (b - a) * ((a.z() - near) / (a.z() - b.z()));
  }
  const Eigen::Isometry3d T_world_camera = camera.T_camera_world.inverse();
  cv::line(picture, sub_pixel(camera.project(T_world_camera * a)),
           sub_pixel(camera.project(T_world_camera * b)), colour, thickness, cv::LINE_AA, fraction_bits);
}

}  // namespace

PictureStyle picture_style(const PictureRequest& request) {
  const double unit = std::clamp(request.height / 1200.0, 0.35, 4.0);
  if (request.dark)
    return {cv::Scalar::all(24), cv::Scalar::all(52), cv::Scalar::all(120), cv::Scalar::all(225), unit};
  return {cv::Scalar::all(250), cv::Scalar::all(226), cv::Scalar::all(120), cv::Scalar::all(30), unit};
}

double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point2d centre, double size,
               const PictureStyle& style) {
  const double scale = size * style.unit;
  const int thickness = pixels(1.4 * scale);
  int baseline = 0;
  const cv::Size extent = cv::getTextSize(text, font, scale, thickness, &baseline);
  const cv::Point origin(cvRound(centre.x - extent.width / 2.0), cvRound(centre.y + extent.height / 2.0));
  cv::putText(picture, text, origin, font, scale, style.background, thickness + pixels(4 * scale),
              cv::LINE_AA);
  cv::putText(picture, text, origin, font, scale, style.text, thickness, cv::LINE_AA);
}

void draw_top_grid(cv::Mat& picture, const ViewCamera& camera, const ViewFrame& frame,
                   const PictureStyle& style) {
  const double step = grid_step(camera, style);
  const cv::Rect inside = rectangle_of(frame);
  for_ticks(camera, frame, 0, step, [&](double column, double) {
    cv::line(picture, {cvRound(column), inside.y}, {cvRound(column), inside.br().y}, style.grid);
  });
  for_ticks(camera, frame, 1, step, [&](double row, double) {
    cv::line(picture, {inside.x, cvRound(row)}, {inside.br().x, cvRound(row)}, style.grid);
  });
}

void draw_top_axes(cv::Mat& picture, const ViewCamera& camera, const ViewFrame& frame,
                   const PictureStyle& style) {
  const cv::Rect inside = rectangle_of(frame);
  cv::Mat outside(picture.size(), CV_8UC1, cv::Scalar(255));
  outside(inside & cv::Rect(0, 0, picture.cols, picture.rows)) = 0;
  picture.setTo(style.background, outside);
  cv::rectangle(picture, inside, style.frame, pixels(1.5 * style.unit));

  const double step = grid_step(camera, style);
  const double size = 0.6, gap = 20 * style.unit, tick = 7 * style.unit;
  const double bottom = frame.top + frame.height;
  for_ticks(camera, frame, 0, step, [&](double column, double value) {
    cv::line(picture, {cvRound(column), cvRound(bottom)}, {cvRound(column), cvRound(bottom + tick)},
             style.frame, pixels(1.5 * style.unit));
    draw_text(picture, metres(value, step), {column, bottom + gap}, size, style);
  });
  for_ticks(camera, frame, 1, step, [&](double row, double value) {
    cv::line(picture, {cvRound(frame.left - tick), cvRound(row)}, {cvRound(frame.left), cvRound(row)},
             style.frame, pixels(1.5 * style.unit));
    draw_text(picture, metres(value, step), {frame.left - 1.6 * gap, row}, size, style);
  });
  draw_text(picture, "x [m]", {frame.left + frame.width / 2, bottom + 2.4 * gap}, size, style);
  draw_text(picture, "y [m]", {frame.left - 1.2 * gap, frame.top - gap}, size, style);

  const double bar = round_step(120 * style.unit / camera.scale);
  const double right = frame.left + frame.width - 1.5 * gap, height = bottom - 1.5 * gap;
  const double left = right - bar * camera.scale;
  const int thickness = pixels(5 * style.unit);
  cv::line(picture, {cvRound(left), cvRound(height)}, {cvRound(right), cvRound(height)}, style.background,
           thickness + pixels(4 * style.unit));
  cv::line(picture, {cvRound(left), cvRound(height)}, {cvRound(right), cvRound(height)}, style.text,
           thickness);
  draw_text(picture, metres(bar, bar) + " m", {(left + right) / 2, height - gap}, 0.7, style);
}

void draw_ground(cv::Mat& picture, const ViewCamera& camera, const std::vector<Eigen::Vector3d>& points,
                 const PictureStyle& style) {
  std::vector<double> coordinates[3];
  for (const Eigen::Vector3d& point : points)
    for (int axis = 0; axis < 3; ++axis) coordinates[axis].push_back(point[axis]);
  double low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = quantile(coordinates[axis], 0.01);
    high[axis] = quantile(coordinates[axis], 0.99);
  }
  const double step = round_step(std::max({(high[0] - low[0]) / 20, (high[1] - low[1]) / 20, 1.0}));
  for (int axis = 0; axis < 2; ++axis) {
    low[axis] = std::floor(low[axis] / step) * step;
    high[axis] = std::ceil(high[axis] / step) * step;
  }
  const int thickness = pixels(1.2 * style.unit);
  for (double x = low[0]; x <= high[0] + 1e-6; x += step)
    draw_segment(picture, camera, {x, low[1], low[2]}, {x, high[1], low[2]}, style.grid, thickness);
  for (double y = low[1]; y <= high[1] + 1e-6; y += step)
    draw_segment(picture, camera, {low[0], y, low[2]}, {high[0], y, low[2]}, style.grid, thickness);
}

void draw_path(cv::Mat& picture, const ViewCamera& camera, const PicturePath& path,
               const PictureStyle& style) {
  const int thickness = pixels(3 * style.unit);
  const auto visit = [&](const cv::Scalar& colour, int width) {
    for (std::size_t i = 1; i < path.points.size(); ++i)
      if (path.points[i - 1].allFinite() && path.points[i].allFinite())
        draw_segment(picture, camera, path.points[i - 1], path.points[i], colour, width);
  };
  visit(style.background, thickness + pixels(2 * style.unit));
  visit(path.colour, thickness);
  if (path.points.empty() || !path.points.front().allFinite()) return;
  const Eigen::Vector3d start = camera.project(path.points.front());
  if (!camera.orthographic && start.z() <= 0) return;
  const int radius = pixels(7 * style.unit * (1 << fraction_bits));
  cv::circle(picture, sub_pixel(start), radius, path.colour, cv::FILLED, cv::LINE_AA, fraction_bits);
  cv::circle(picture, sub_pixel(start), radius, style.background, pixels(2 * style.unit), cv::LINE_AA,
             fraction_bits);
}

void draw_landmarks(cv::Mat& picture, const ViewCamera& camera, const std::vector<Landmark>& landmarks,
                    const PictureStyle& style) {
  std::vector<std::pair<double, const Landmark*>> ordered;
  for (const Landmark& landmark : landmarks)
    if (landmark.mean.allFinite()) ordered.emplace_back(camera.project(landmark.mean).z(), &landmark);
  std::stable_sort(ordered.begin(), ordered.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  // Thousands of dots get smaller, so that the room's shape stays to be seen.
  const double crowd = std::clamp(std::sqrt(1000.0 / static_cast<double>(ordered.size() + 1)), 0.45, 1.0);
  for (const auto& [depth, landmark] : ordered) {
    if (!camera.orthographic && depth <= 0.05) continue;
    // 7 pixels at a standard deviation of 1 cm, falling to 2 at 1 m, where there are few.
    const double sigma = std::sqrt(std::max(landmark->covariance.trace() / 3, 1e-4));
    const double certainty = std::isfinite(sigma) ? std::clamp(-std::log10(sigma) / 2, 0.0, 1.0) : 0;
    const double radius = (2 + 5 * certainty) * crowd * style.unit;
    const cv::Scalar colour(landmark->colour[2], landmark->colour[1], landmark->colour[0]);
    const cv::Point centre = sub_pixel(camera.project(landmark->mean));
    const double one = 1 << fraction_bits;
    cv::circle(picture, centre, pixels((radius + crowd * style.unit) * one), style.frame, cv::FILLED,
               cv::LINE_AA, fraction_bits);
    cv::circle(picture, centre, pixels(radius * one), colour, cv::FILLED, cv::LINE_AA, fraction_bits);
  }
}

void draw_title_and_legend(cv::Mat& picture, const PictureRequest& request, const PictureStyle& style) {
  const double u = style.unit;
  draw_text(picture, request.title, {picture.cols / 2.0, 30 * u}, 1.0, style);
  std::vector<const PicturePath*> named;
  int widest = 0, baseline = 0;
  for (const PicturePath& path : request.paths) {
    if (path.name.empty()) continue;
    named.push_back(&path);
    widest = std::max(widest, cv::getTextSize(path.name, font, 0.7 * u, pixels(u), &baseline).width);
  }
  if (named.empty()) return;
  const double row_height = 34 * u, line_length = 50 * u, margin = 16 * u;
  const double width = line_length + widest + 3 * margin;
  const double left = picture.cols - width - 115 * u, top = 90 * u;
  const cv::Rect box(cvRound(left), cvRound(top), cvRound(width),
                     cvRound(row_height * static_cast<double>(named.size()) + margin));
  cv::rectangle(picture, box, style.background, cv::FILLED);
  cv::rectangle(picture, box, style.frame, pixels(u));
  double row = top + margin / 2 + row_height / 2;
  for (const PicturePath* path : named) {
    const double start = left + margin;
    cv::line(picture, {cvRound(start), cvRound(row)}, {cvRound(start + line_length), cvRound(row)},
             path->colour, pixels(4 * u), cv::LINE_AA);
    const int length = cv::getTextSize(path->name, font, 0.7 * u, pixels(u), &baseline).width;
    draw_text(picture, path->name, {start + line_length + margin + length / 2.0, row}, 0.7, style);
    row += row_height;
  }
}

}  // namespace lcmslam
