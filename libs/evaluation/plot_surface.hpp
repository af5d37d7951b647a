#pragma once
// What a plot is drawn on: pixels or SVG. Internal to lcmslam_evaluation.

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace lcmslam {

using PlotColour = std::array<unsigned char, 3>;  ///< R, G, B

/// Coordinates in pixels from the upper left corner, x to the right, y downwards.
class PlotSurface {
 public:
  enum class Anchor { left, middle, right };

  virtual ~PlotSurface() = default;
  virtual void line(const cv::Point2d& a, const cv::Point2d& b, const PlotColour& colour, int thickness) = 0;
  /// At least two points.
  virtual void polyline(const std::vector<cv::Point2d>& points, const PlotColour& colour) = 0;
  virtual void disc(const cv::Point2d& centre, double radius, const PlotColour& colour) = 0;
  virtual void filled_box(const cv::Rect2d& box, const PlotColour& colour) = 0;
  virtual void box(const cv::Rect2d& box, const PlotColour& colour) = 0;
  /// One line; `position` is on its base line.
  virtual void text(const std::string& text, const cv::Point2d& position, const PlotColour& colour,
                    Anchor anchor = Anchor::left) = 0;
  virtual double text_width(const std::string& text) const = 0;
};

/// Anti-aliased lines in a CV_8UC3 image (BGR).
class RasterSurface : public PlotSurface {
 public:
  RasterSurface(int width, int height);
  cv::Mat image() const { return image_; }

  void line(const cv::Point2d& a, const cv::Point2d& b, const PlotColour& colour, int thickness) override;
  void polyline(const std::vector<cv::Point2d>& points, const PlotColour& colour) override;
  void disc(const cv::Point2d& centre, double radius, const PlotColour& colour) override;
  void filled_box(const cv::Rect2d& box, const PlotColour& colour) override;
  void box(const cv::Rect2d& box, const PlotColour& colour) override;
  void text(const std::string& text, const cv::Point2d& position, const PlotColour& colour,
            Anchor anchor) override;
  double text_width(const std::string& text) const override;

 private:
  cv::Mat image_;
};

/// SVG 1.1 text.
class SvgSurface : public PlotSurface {
 public:
  SvgSurface(int width, int height);
  /// The whole document.
  std::string document() const { return body_ + "</svg>\n"; }

  void line(const cv::Point2d& a, const cv::Point2d& b, const PlotColour& colour, int thickness) override;
  void polyline(const std::vector<cv::Point2d>& points, const PlotColour& colour) override;
  void disc(const cv::Point2d& centre, double radius, const PlotColour& colour) override;
  void filled_box(const cv::Rect2d& box, const PlotColour& colour) override;
  void box(const cv::Rect2d& box, const PlotColour& colour) override;
  void text(const std::string& text, const cv::Point2d& position, const PlotColour& colour,
            Anchor anchor) override;
  double text_width(const std::string& text) const override;

 private:
  std::string body_;
};

}  // namespace lcmslam
