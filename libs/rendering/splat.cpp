#include <lcmslam/rendering/splat.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace lcmslam {
namespace {

constexpr int supersampling = 2;
// Disc radius over point spacing: closes a square grid (0.71), noise and clusters; paint has nothing to
// close.
constexpr double overlap = 1.2, paint_overlap = 0.95;
constexpr double max_radius = 60;   // pixels
constexpr float roughness = 0.03F;  // m, of a surface as depth cameras see it: what lies deeper is hidden
constexpr float nothing = std::numeric_limits<float>::infinity();

using Four = float __attribute__((vector_size(16)));

struct Disc {
  int left, right, top, bottom;  // clipped bounds, inclusive
  double x, y, radius;
  float depth;
  float share;  // of the colour where discs overlap: the smaller, the sharper
  cv::Vec3b colour;
  bool paint;
};

/// Calls visit(row, first column, columns) for the parts of a disc's rows that lie in the band.
template <class Visit>
void for_rows(const Disc& disc, const cv::Range& band, const Visit& visit) {
  for (int row = std::max(disc.top, band.start); row <= std::min(disc.bottom, band.end - 1); ++row) {
    const double dy = row - disc.y, half = std::sqrt(std::max(0.0, disc.radius * disc.radius - dy * dy));
    const int first = std::max(disc.left, cvCeil(disc.x - half));
    const int last = std::min(disc.right, cvFloor(disc.x + half));
    if (first <= last) visit(row, first, last - first + 1);
  }
}

/// Adds `colour` to the sums of those pixels that lie in the front surface; what lies behind it by more than
/// its roughness is hidden and gets nothing.
void blend_row(const float* nearest, const float* along, int columns, float depth, float of_row,
               const Four& colour, cv::Vec4f* sums) {
  const Four by_value = colour;
  for (int column = 0; column < columns; ++column) {
    const bool hidden = std::abs(depth - nearest[column]) > roughness;
    const float weight = hidden ? 0 : of_row * along[column];
    Four sum;
    std::memcpy(&sum, sums[column].val, sizeof sum);
    sum += weight * by_value;
    std::memcpy(sums[column].val, &sum, sizeof sum);
  }
}

std::vector<Disc> project_discs(const ViewCamera& camera, const std::vector<SplatPoint>& points,
                                const cv::Size& size) {
  constexpr double near = 0.05;  // m
  std::vector<Disc> discs;
  discs.reserve(points.size());
  for (const SplatPoint& point : points) {
    const Eigen::Vector3d pixel = camera.project(point.position);
    if (!camera.orthographic && !(pixel.z() > near)) continue;
    Disc disc;
    disc.radius = std::clamp((point.paint ? paint_overlap : overlap) * static_cast<double>(point.spacing) *
                                 camera.pixels_per_metre(pixel.z()) * supersampling,
                             0.5 * supersampling, max_radius);
    // The centre of output pixel c is at supersampled column s (c + 1/2) - 1/2.
    disc.x = supersampling * (pixel.x() + 0.5) - 0.5;
    disc.y = supersampling * (pixel.y() + 0.5) - 0.5;
    const double r = disc.radius;
    if (!(disc.x + r >= 0 && disc.y + r >= 0 && disc.x - r < size.width && disc.y - r < size.height))
      continue;
    disc.left = std::max(0, static_cast<int>(std::ceil(disc.x - r)));
    disc.right = std::min(size.width - 1, static_cast<int>(std::floor(disc.x + r)));
    disc.top = std::max(0, static_cast<int>(std::ceil(disc.y - r)));
    disc.bottom = std::min(size.height - 1, static_cast<int>(std::floor(disc.y + r)));
    disc.depth = static_cast<float>(pixel.z());
    disc.share = 1e-4F / (point.spacing * point.spacing);
    disc.colour = point.colour;
    disc.paint = point.paint;
    discs.push_back(disc);
  }
  return discs;
}

/// Some rows of the supersampled picture at a time: all of it would be a hundred megabytes.
class Band {
 public:
  static constexpr int reach = 3;  // supersampled pixels, of the light

  Band(const cv::Size& size, int rows)
      : size_(size), depth_(rows + 2 * reach, size.width), sum_(rows, size.width) {}

  /// Draws rows `band` of the discs that reach into them, in their order. `layer`: colours times coverage,
  /// coverage.
  void draw(const std::vector<Disc>& discs, const std::vector<std::size_t>& reaching, const cv::Range& band,
            bool orthographic, cv::Mat4f& layer) {
    band_ = band;
    around_ = {std::max(0, band.start - reach), std::min(size_.height, band.end + reach)};
    depth_.setTo(nothing);
    sum_.setTo(0);
    for (const std::size_t i : reaching)
      if (!discs[i].paint) hide_behind(discs[i]);
    for (const std::size_t i : reaching) blend(discs[i]);
    for (int row = band.start; row < band.end; ++row) light(row, orthographic);
    cv::resize(sum_.rowRange(0, band.size()), layer,
               {size_.width / supersampling, band.size() / supersampling}, 0, 0, cv::INTER_AREA);
  }

 private:
  float* depth(int row) { return depth_[row - around_.start]; }

  void hide_behind(const Disc& disc) {
    const float own = disc.depth;
    for_rows(disc, around_, [&](int row, int first, int columns) {
      float* nearest = depth(row) + first;
      for (int column = 0; column < columns; ++column) nearest[column] = std::min(nearest[column], own);
    });
  }

  void blend(const Disc& disc) {
    const Four colour = {static_cast<float>(disc.colour[0]), static_cast<float>(disc.colour[1]),
                         static_cast<float>(disc.colour[2]), 1};
    const auto steepness = static_cast<float>(-4 / (disc.radius * disc.radius));
    const auto weight = [&](double way) { return std::exp(steepness * static_cast<float>(way * way)); };
    along_.clear();  // the weight is a product of a row's and a column's
    for (int column = disc.left; column <= disc.right; ++column) along_.push_back(weight(column - disc.x));
    for_rows(disc, band_, [&](int row, int first, int columns) {
      blend_row(depth(row) + first, along_.data() + (first - disc.left), columns, disc.depth,
                disc.share * weight(row - disc.y), colour, sum_[row - band_.start] + first);
    });
  }

  void light(int row, bool orthographic) {
    cv::Vec4f* sum = sum_[row - band_.start];
    for (int column = 0; column < size_.width; ++column) {
      cv::Vec4f& pixel = sum[column];
      if (pixel[3] <= 0) continue;
      const float light = eye_dome_light(row, column, orthographic) / pixel[3];
      pixel = cv::Vec4f(pixel[0] * light, pixel[1] * light, pixel[2] * light, 1);
    }
  }

  /// Darkens pixels that lie behind their neighbours, 1 where flat.
  float eye_dome_light(int row, int column, bool orthographic) {
    constexpr float strength = 1.2F, most = 0.35F;
    const float own = depth(row)[column];
    float behind = 0;
    for (const auto& [dy, dx] : {std::pair{-reach, 0}, {reach, 0}, {0, -reach}, {0, reach}}) {
      const int y = row + dy, x = column + dx;
      if (y < 0 || x < 0 || y >= size_.height || x >= size_.width) continue;
      if (!(depth(y)[x] < own)) continue;  // also where there is nothing
      const float step = orthographic ? 0.3F * (own - depth(y)[x]) : std::log(own / depth(y)[x]);
      behind += std::min(step, most);
    }
    return behind > 0 ? std::exp(-strength * behind) : 1;
  }

  cv::Size size_;
  cv::Range band_, around_;  // rows that are drawn; with those that throw their light on them
  cv::Mat1f depth_;
  cv::Mat4f sum_;  // weighted BGR, weight
  std::vector<float> along_;
};

}  // namespace

void draw_splats(cv::Mat& picture, const ViewCamera& camera, const std::vector<SplatPoint>& points) {
  constexpr int band_rows = 32 * supersampling;
  const cv::Size size(picture.cols * supersampling, picture.rows * supersampling);
  const std::vector<Disc> discs = project_discs(camera, points, size);
  const int bands = (size.height + band_rows - 1) / band_rows;
  std::vector<std::vector<std::size_t>> reaching(static_cast<std::size_t>(bands));
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const int first = std::max(0, discs[i].top - Band::reach) / band_rows;
    const int last = std::min(bands - 1, (discs[i].bottom + Band::reach) / band_rows);
    for (int b = first; b <= last; ++b) reaching[static_cast<std::size_t>(b)].push_back(i);
  }

  Band band(size, band_rows);
  cv::Mat4f layer;
  for (int b = 0; b < bands; ++b) {
    if (reaching[static_cast<std::size_t>(b)].empty()) continue;
    const cv::Range rows(b * band_rows, std::min((b + 1) * band_rows, size.height));
    band.draw(discs, reaching[static_cast<std::size_t>(b)], rows, camera.orthographic, layer);
    for (int row = 0; row < layer.rows; ++row)
      for (int column = 0; column < picture.cols; ++column) {
        const cv::Vec4f& over = layer(row, column);
        if (over[3] == 0) continue;
        cv::Vec3b& under = picture.at<cv::Vec3b>(rows.start / supersampling + row, column);
        for (int channel = 0; channel < 3; ++channel)
          under[channel] =
              cv::saturate_cast<uchar>(over[channel] + (1 - over[3]) * static_cast<float>(under[channel]));
      }
  }
}

}  // namespace lcmslam
