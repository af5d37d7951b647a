#include <cmath>
#include <opencv2/imgproc.hpp>

#include <lcmslam/evaluation/plot_surface.hpp>

namespace lcmslam {
namespace {

constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr double font_scale = 0.5;
constexpr int sub_pixel_bits = 4;

cv::Scalar bgr(const PlotColour& colour) {
  return {double(colour[2]), double(colour[1]), double(colour[0])};
}

cv::Point whole(const cv::Point2d& p) {
  return {cvRound(p.x), cvRound(p.y)};
}

cv::Point sub_pixel(const cv::Point2d& p) {
  constexpr double factor = 1 << sub_pixel_bits;
  return {cvRound(p.x * factor), cvRound(p.y * factor)};
}

}  // namespace

RasterSurface::RasterSurface(int width, int height) : image_(height, width, CV_8UC3, cv::Scalar::all(255)) {}

void RasterSurface::line(const cv::Point2d& a, const cv::Point2d& b, const PlotColour& colour,
                         int thickness) {
  cv::line(image_, whole(a), whole(b), bgr(colour), thickness);
}

void RasterSurface::polyline(const std::vector<cv::Point2d>& points, const PlotColour& colour) {
  std::vector<cv::Point> pixels;
  pixels.reserve(points.size());
  for (const cv::Point2d& p : points) pixels.push_back(sub_pixel(p));
  cv::polylines(image_, pixels, false, bgr(colour), 2, cv::LINE_AA, sub_pixel_bits);
}

void RasterSurface::disc(const cv::Point2d& centre, double radius, const PlotColour& colour) {
  cv::circle(image_, whole(centre), cvRound(radius), bgr(colour), cv::FILLED, cv::LINE_AA);
}

void RasterSurface::filled_box(const cv::Rect2d& box, const PlotColour& colour) {
  cv::rectangle(image_, whole(box.tl()), whole(box.br()), bgr(colour), cv::FILLED);
}

void RasterSurface::box(const cv::Rect2d& box, const PlotColour& colour) {
  cv::rectangle(image_, whole(box.tl()), whole(box.br()), bgr(colour));
}

void RasterSurface::text(const std::string& text, const cv::Point2d& position, const PlotColour& colour,
                         Anchor anchor) {
  const double shift = anchor == Anchor::left ? 0 : anchor == Anchor::middle ? 0.5 : 1;
  const cv::Point2d left = position - cv::Point2d(shift * text_width(text), 0);
  cv::putText(image_, text, whole(left), font, font_scale, bgr(colour), 1, cv::LINE_AA);
}

double RasterSurface::text_width(const std::string& text) const {
  int baseline = 0;
  return cv::getTextSize(text, font, font_scale, 1, &baseline).width;
}

}  // namespace lcmslam
