#include <lcmslam/simulation/painter.hpp>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

int pixels(double metres, const PaintSettings& settings) {
  return std::max(2, static_cast<int>(metres / settings.texel + 0.5));
}

int random_int(Random& random, int low, int high) {  // low..high
  return low + static_cast<int>(random.below(static_cast<std::uint64_t>(std::max(1, high - low + 1))));
}

cv::Point random_point(Random& random, const cv::Mat& canvas) {
  const int x = random_int(random, 0, canvas.cols - 1);
  return {x, random_int(random, 0, canvas.rows - 1)};
}

cv::Scalar random_colour(Random& random) {
  const double b = random.uniform(20, 235), g = random.uniform(20, 235);
  return {b, g, random.uniform(20, 235)};
}

cv::Scalar scaled(const cv::Scalar& colour, double factor) {
  return {std::min(255.0, colour[0] * factor), std::min(255.0, colour[1] * factor),
          std::min(255.0, colour[2] * factor)};
}

/// One random filled circle, triangle or rectangle of about `size` pixels.
void draw_shape(cv::Mat& canvas, cv::Point centre, int size, const cv::Scalar& colour, Random& random) {
  const int kind = random_int(random, 0, 2);
  if (kind == 0) return cv::circle(canvas, centre, size / 2, colour, cv::FILLED, cv::LINE_AA);
  if (kind == 1) {
    const cv::RotatedRect box(centre, cv::Size2f(static_cast<float>(size), 0.6f * static_cast<float>(size)),
                              static_cast<float>(random.uniform(0, 180)));
    cv::Point2f corners[4];
    box.points(corners);
    const std::vector<cv::Point> polygon(corners, corners + 4);
    return cv::fillConvexPoly(canvas, polygon, colour, cv::LINE_AA);
  }
  std::vector<cv::Point> polygon;
  for (int i = 0; i < 3; ++i) {
    const int dx = random_int(random, -size / 2, size / 2);
    polygon.push_back(centre + cv::Point(dx, random_int(random, -size / 2, size / 2)));
  }
  cv::fillConvexPoly(canvas, polygon, colour, cv::LINE_AA);
}

void draw_text(cv::Mat& canvas, const std::string& text, cv::Point start, double height,
               const cv::Scalar& colour) {
  const double scale = height / 22;  // Hershey capitals are 22 pixels high at scale 1
  cv::putText(canvas, text, start, cv::FONT_HERSHEY_SIMPLEX, scale, colour,
              std::max(1, static_cast<int>(2 * scale)), cv::LINE_AA);
}

void plain(cv::Mat&, const PaintSettings&, Random&) {}

/// Stone: grains of several sizes and tones.
void speckle(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int grains = canvas.rows * canvas.cols / 60;
  for (int i = 0; i < grains; ++i) {
    const double tone = 1 + settings.variation * random.uniform(-1, 1) * 4;
    const cv::Point centre = random_point(random, canvas);
    const int radius = random_int(random, 1, random.uniform() < 0.06 ? pixels(settings.cell, settings) : 3);
    cv::ellipse(canvas, centre, {radius, std::max(1, radius * 2 / 3)}, random.uniform(0, 180), 0, 360,
                scaled(settings.colour, std::max(0.1, tone)), cv::FILLED, cv::LINE_AA);
  }
}

/// Tiles of differing tone with grout between them; some carry a drawing.
void tiles(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int cell = pixels(settings.cell, settings), grout = std::max(1, pixels(0.004, settings) / 2);
  for (int top = 0; top < canvas.rows; top += cell)
    for (int left = 0; left < canvas.cols; left += cell) {
      const cv::Rect tile(left, top, cell, cell);
      const double tone = 1 + settings.variation * random.uniform(-1, 1);
      cv::rectangle(canvas, tile, scaled(settings.colour, tone), cv::FILLED);
      if (random.uniform() < settings.variation * 1.5) {
        cv::Mat inside = canvas(tile & cv::Rect(0, 0, canvas.cols, canvas.rows));
        const cv::Point middle(inside.cols / 2, inside.rows / 2);
        for (int i = 0; i < 5; ++i) {
          const cv::Point offset(random_int(random, -cell / 4, cell / 4),
                                 random_int(random, -cell / 4, cell / 4));
          const cv::Scalar colour = i % 2 ? settings.accent : random_colour(random);
          draw_shape(inside, middle + offset, random_int(random, cell / 6, cell / 2), colour, random);
        }
      }
      cv::rectangle(canvas, tile, scaled(settings.colour, 0.72), grout);
    }
  shade_randomly(canvas, cell * 3, 0.05, random);
}

/// Planks across the canvas with grain and knots.
void wood(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int plank = pixels(settings.cell, settings);
  for (int top = 0; top < canvas.rows; top += plank) {
    const double tone = 1 + settings.variation * random.uniform(-1, 1);
    const cv::Rect area = cv::Rect(0, top, canvas.cols, plank) & cv::Rect(0, 0, canvas.cols, canvas.rows);
    cv::Mat board = canvas(area);
    board.setTo(scaled(settings.colour, tone));
    for (int i = 0; i < plank; ++i) {
      const double grain = tone * (1 + settings.variation * random.uniform(-1.2, 0.6));
      const int y = random_int(random, 0, area.height - 1), x = random_int(random, 0, area.width - 1);
      const int end = x + random_int(random, area.width / 8, area.width / 2);
      cv::line(board, {x, y}, {end, y + random_int(random, -2, 2)}, scaled(settings.colour, grain), 1,
               cv::LINE_AA);
    }
    for (int i = 0; i < area.width / 90; ++i)
      if (random.uniform() < 3 * settings.variation) {
        const int radius = random_int(random, 2, std::max(3, plank / 10));
        cv::ellipse(board, random_point(random, board), {radius * 2, radius}, 0, 0, 360,
                    scaled(settings.colour, 0.5 * tone), cv::FILLED, cv::LINE_AA);
      }
    cv::line(canvas, {0, top}, {canvas.cols, top}, scaled(settings.colour, 0.55), 1);
    const int joint = random_int(random, 0, canvas.cols - 1);
    cv::line(canvas, {joint, top}, {joint, top + plank}, scaled(settings.colour, 0.55), 1);
  }
}

/// Shapes, lines and words with a frame.
void poster(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int size = std::min(canvas.cols, canvas.rows);
  for (int i = 0; i < 60; ++i)
    draw_shape(canvas, random_point(random, canvas),
               random_int(random, size / 25, i < 15 ? size / 3 : size / 9), random_colour(random), random);
  for (int i = 0; i < 12; ++i) {
    std::string word = settings.text.empty() ? "" : settings.text + " ";
    for (int k = random_int(random, 3, 8); k > 0; --k)
      word += static_cast<char>('A' + random_int(random, 0, 25));
    draw_text(canvas, word, random_point(random, canvas) - cv::Point(size / 4, 0),
              random.uniform(0.03, i < 2 ? 0.16 : 0.07) * size,
              i % 2 ? settings.accent : random_colour(random));
  }
  cv::rectangle(canvas, {0, 0, canvas.cols, canvas.rows}, settings.accent, std::max(2, size / 30));
}

/// A packet or tin: bands of colour, a big word and small print.
void label(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int rows = canvas.rows, cols = canvas.cols;
  cv::rectangle(canvas, {0, rows / 4, cols, rows / 3}, settings.accent, cv::FILLED);
  for (int i = 0; i < 6; ++i)
    draw_shape(canvas, random_point(random, canvas), random_int(random, cols / 12, cols / 4),
               random_colour(random), random);
  for (int left = 0; left < cols; left += std::max(8, cols / 2))
    draw_text(canvas, settings.text, {left + cols / 30, rows / 2}, 0.16 * rows, settings.colour);
  for (int line = 0; line < 5; ++line)
    for (int x = cols / 20; x < cols - cols / 10; x += cols / 14)
      if (random.uniform() < 0.75)
        cv::line(canvas, {x, rows * (14 + line) / 20}, {x + cols / 20, rows * (14 + line) / 20},
                 scaled(settings.accent, 0.4), std::max(1, rows / 90), cv::LINE_AA);
}

/// A cupboard door with a panel, a handle and faint grain.
void door(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  wood(canvas, settings, random);
  const int gap = pixels(0.006, settings), inset = std::min(canvas.cols, canvas.rows) / 7;
  const cv::Rect all(0, 0, canvas.cols, canvas.rows);
  cv::rectangle(canvas, all, scaled(settings.colour, 0.35), gap);
  const cv::Rect panel(inset, inset, canvas.cols - 2 * inset, canvas.rows - 2 * inset);
  cv::rectangle(canvas, panel, scaled(settings.colour, 0.7), gap / 2 + 1);
  const int x = canvas.cols - inset / 2, y = canvas.rows / 6, length = pixels(0.14, settings);
  cv::line(canvas, {x, y}, {x, y + length}, settings.accent, pixels(0.014, settings), cv::LINE_AA);
}

/// Dark glass, knobs, a display and a bar.
void oven(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int rows = canvas.rows, cols = canvas.cols;
  cv::rectangle(canvas, {cols / 12, rows / 3, cols * 5 / 6, rows / 2}, {35, 30, 28}, cv::FILLED);
  for (int i = 0; i < 5; ++i)
    cv::line(canvas, {cols / 10, rows * (8 + i) / 20}, {cols * 9 / 10, rows * (8 + i) / 20}, {75, 80, 85}, 2);
  cv::rectangle(canvas, {cols / 12, rows / 4, cols * 5 / 6, rows / 30}, settings.accent, cv::FILLED);
  for (int i = 0; i < 5; ++i) {
    const cv::Point centre(cols * (2 + 4 * i) / 20, rows / 9);
    if (i == 2) {
      cv::rectangle(canvas, {centre.x - cols / 12, centre.y - rows / 20, cols / 6, rows / 10}, {20, 30, 20},
                    cv::FILLED);
      draw_text(canvas, "12:47", {centre.x - cols / 14, centre.y + rows / 40}, rows / 20.0, {80, 240, 90});
      continue;
    }
    cv::circle(canvas, centre, cols / 22, {40, 40, 40}, cv::FILLED, cv::LINE_AA);
    const double angle = random.uniform(0, 6.28);
    cv::line(canvas, centre,
             centre + cv::Point(cv::Point2d(cols / 24.0 * std::cos(angle), cols / 24.0 * std::sin(angle))),
             {240, 240, 240}, 2, cv::LINE_AA);
  }
  draw_text(canvas, settings.text, {cols / 3, rows * 19 / 20}, rows / 22.0, {60, 60, 60});
}

/// A row of book spines.
void books(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  canvas.setTo(cv::Scalar(30, 30, 35));
  const int shelf = std::max(8, pixels(settings.cell * 8, settings));
  for (int bottom = shelf; bottom <= canvas.rows + shelf / 2; bottom += shelf)
    for (int x = 0; x < canvas.cols;) {
      const int width = pixels(settings.cell * random.uniform(0.6, 1.6), settings);
      const int height = static_cast<int>(shelf * random.uniform(0.68, 0.95));
      const cv::Rect spine(x, bottom - height, width, height);
      cv::rectangle(canvas, spine, random_colour(random), cv::FILLED);
      const cv::Scalar print = random_colour(random);
      for (int k = 0; k < 3; ++k)
        cv::rectangle(canvas,
                      {x + width / 5, bottom - height * random_int(random, 1, 9) / 10, width * 3 / 5,
                       height / random_int(random, 9, 30) + 1},
                      print, cv::FILLED);
      cv::rectangle(canvas, spine, {15, 15, 15}, 1);
      x += width;
    }
}

/// A pattern of small lozenges and lines.
void carpet(cv::Mat& canvas, const PaintSettings& settings, Random& random) {
  const int cell = pixels(settings.cell, settings);
  for (int i = 0; i < canvas.rows * canvas.cols / (cell * cell) * 2; ++i) {
    const cv::Scalar colour =
        random.uniform() < 0.5 ? settings.accent : scaled(settings.colour, random.uniform(0.5, 1.4));
    draw_shape(canvas, random_point(random, canvas), random_int(random, cell / 4, cell), colour, random);
  }
  shade_randomly(canvas, 2, 2 * settings.variation, random);
}

}  // namespace

void shade_randomly(cv::Mat& canvas, int scale, double strength, Random& random) {
  cv::Mat coarse(std::max(2, canvas.rows / std::max(1, scale)), std::max(2, canvas.cols / std::max(1, scale)),
                 CV_32FC1);
  for (int y = 0; y < coarse.rows; ++y)
    for (int x = 0; x < coarse.cols; ++x)
      coarse.at<float>(y, x) = static_cast<float>(1 + strength * std::clamp(random.normal(), -2.5, 2.5));
  cv::Mat factor;
  cv::resize(coarse, factor, canvas.size(), 0, 0, cv::INTER_CUBIC);
  for (int y = 0; y < canvas.rows; ++y)
    for (int x = 0; x < canvas.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        auto& value = canvas.at<cv::Vec3b>(y, x)[c];
        value = cv::saturate_cast<std::uint8_t>(static_cast<float>(value) * factor.at<float>(y, x));
      }
}

const std::map<std::string, Painter>& painters() {
  static const std::map<std::string, Painter> all = {
      {"plain", plain}, {"speckle", speckle}, {"tiles", tiles}, {"wood", wood},   {"poster", poster},
      {"label", label}, {"door", door},       {"oven", oven},   {"books", books}, {"carpet", carpet}};
  return all;
}

}  // namespace lcmslam
