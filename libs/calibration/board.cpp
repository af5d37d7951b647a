#include <lcmslam/calibration/board.hpp>

#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int marker_bits = 5, border_bits = 1, marker_side = marker_bits + 2 * border_bits;

/// The black cells of a marker in the square with its upper left corner at (x, y).
void add_marker(int id, double x, double y, const BoardSettings& settings, std::vector<cv::Rect2d>& black) {
  cv::Mat cells;
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(Board::dictionary()), id, marker_side, cells,
                        border_bits);
  const double side = settings.marker * settings.square, cell = side / marker_side;
  const double margin = 0.5 * (settings.square - side);
  for (int v = 0; v < marker_side; ++v) {
    int u = 0;
    while (u < marker_side) {  // black cells beside one another are one rectangle: printers leave hairlines
      int end = u;
      while (end < marker_side && cells.at<std::uint8_t>(v, end) == 0) ++end;
      if (end > u) black.emplace_back(x + margin + u * cell, y + margin + v * cell, (end - u) * cell, cell);
      u = end + 1;
    }
  }
}

}  // namespace

int Board::dictionary() {
  return cv::aruco::DICT_5X5_1000;
}

Board::Board(const BoardSettings& settings) : settings_(settings) {
  check(settings_, "board");
  int marker = 0;
  for (int row = 0; row < settings_.rows; ++row)
    for (int column = 0; column < settings_.columns; ++column) {
      const double x = column * settings_.square, y = row * settings_.square;
      if ((row + column) % 2 == 0)
        black_.emplace_back(x, y, settings_.square, settings_.square);
      else if (has_markers())
        add_marker(marker++, x, y, settings_, black_);
    }
}

Eigen::Vector3d Board::corner(int id) const {
  const int across = settings_.columns - 1;
  return {(id % across + 1) * settings_.square, (id / across + 1) * settings_.square, 0};
}

cv::Mat Board::picture(int pixels_per_square) const {
  const double scale = pixels_per_square / settings_.square, margin = 0.5 * pixels_per_square;
  cv::Mat image((settings_.rows + 1) * pixels_per_square, (settings_.columns + 1) * pixels_per_square,
                CV_8UC1, cv::Scalar(255));
  for (const cv::Rect2d& r : black_) {
    const cv::Point from(cvRound(margin + scale * r.x), cvRound(margin + scale * r.y));
    const cv::Point to(cvRound(margin + scale * (r.x + r.width)), cvRound(margin + scale * (r.y + r.height)));
    image(cv::Rect(from, to)).setTo(0);
  }
  return image;
}

std::string Board::svg() const {
  const double margin = 500 * settings_.square, text = 5;  // mm
  const double across = 1000 * width() + 2 * margin, down = 1000 * height() + 2 * margin + text;
  std::ostringstream svg;
  svg.imbue(std::locale::classic());
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << across << "mm\" height=\"" << down
      << "mm\" viewBox=\"0 0 " << across << " " << down << "\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<g fill=\"black\">\n";
  for (const cv::Rect2d& r : black_)
    svg << "<rect x=\"" << margin + 1000 * r.x << "\" y=\"" << margin + 1000 * r.y << "\" width=\""
        << 1000 * r.width << "\" height=\"" << 1000 * r.height << "\"/>\n";
  svg << "</g>\n<text x=\"" << margin << "\" y=\"" << down - 1
      << "\" font-family=\"sans-serif\" font-size=\"4\">" << settings_.kind << " " << settings_.columns
      << " x " << settings_.rows << ", squares of " << 1000 * settings_.square
      << " mm: measure them on the print</text>\n</svg>\n";
  return svg.str();
}

}  // namespace lcmslam
