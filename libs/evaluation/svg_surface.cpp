#include <lcmslam/evaluation/plot_surface.hpp>
#include <lcmslam/evaluation/table.hpp>

namespace lcmslam {
namespace {

constexpr double font_size = 14;         // pixels
constexpr double character_width = 7.5;  // about, of a sans-serif font of that size

std::string number(double value) {
  return fixed_number(value, 2);
}

/// name="value" with a blank before it.
std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + "\"";
}

std::string at(const char* x_name, const char* y_name, const cv::Point2d& p) {
  return attribute(x_name, number(p.x)) + attribute(y_name, number(p.y));
}

std::string colour_text(const PlotColour& c) {
  return "rgb(" + std::to_string(c[0]) + "," + std::to_string(c[1]) + "," + std::to_string(c[2]) + ")";
}

/// XML knows no control characters and takes these three for its own.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '&')
      result += "&amp;";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result;
}

std::string box_text(const cv::Rect2d& box) {
  return "<rect" + at("x", "y", box.tl()) + attribute("width", number(box.width)) +
         attribute("height", number(box.height));
}

}  // namespace

SvgSurface::SvgSurface(int width, int height)
    : body_("<svg xmlns=\"http://www.w3.org/2000/svg\"" + attribute("width", std::to_string(width)) +
            attribute("height", std::to_string(height)) + attribute("font-size", number(font_size)) +
            attribute("font-family", "sans-serif") + ">\n") {
  filled_box(cv::Rect2d(0, 0, width, height), {255, 255, 255});
}

void SvgSurface::line(const cv::Point2d& a, const cv::Point2d& b, const PlotColour& colour, int thickness) {
  body_ += "<line" + at("x1", "y1", a) + at("x2", "y2", b) + attribute("stroke", colour_text(colour)) +
           attribute("stroke-width", std::to_string(thickness)) + "/>\n";
}

void SvgSurface::polyline(const std::vector<cv::Point2d>& points, const PlotColour& colour) {
  std::string list;
  for (const cv::Point2d& p : points) list += (list.empty() ? "" : " ") + number(p.x) + "," + number(p.y);
  body_ += "<polyline" + attribute("points", list) + attribute("fill", "none") +
           attribute("stroke", colour_text(colour)) + attribute("stroke-width", "2") +
           attribute("stroke-linejoin", "round") + "/>\n";
}

void SvgSurface::disc(const cv::Point2d& centre, double radius, const PlotColour& colour) {
  body_ += "<circle" + at("cx", "cy", centre) + attribute("r", number(radius)) +
           attribute("fill", colour_text(colour)) + "/>\n";
}

void SvgSurface::filled_box(const cv::Rect2d& box, const PlotColour& colour) {
  body_ += box_text(box) + attribute("fill", colour_text(colour)) + "/>\n";
}

void SvgSurface::box(const cv::Rect2d& box, const PlotColour& colour) {
  body_ += box_text(box) + attribute("fill", "none") + attribute("stroke", colour_text(colour)) + "/>\n";
}

void SvgSurface::text(const std::string& text, const cv::Point2d& position, const PlotColour& colour,
                      Anchor anchor) {
  body_ += "<text" + at("x", "y", position) + attribute("fill", colour_text(colour));
  if (anchor != Anchor::left) body_ += attribute("text-anchor", anchor == Anchor::middle ? "middle" : "end");
  body_ += ">" + escaped(text) + "</text>\n";
}

double SvgSurface::text_width(const std::string& text) const {
  return character_width * static_cast<double>(text.size());
}

}  // namespace lcmslam
