#include <lcmslam/rendering/splat.hpp>

#include <algorithm>
#include <cmath>
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

struct Disc {
  int left, right, top, bottom;  // clipped bounds, inclusive
  double x, y, radius;
  float depth;
  float share;  // of the colour where discs overlap: the smaller, the sharper
  cv::Vec3b colour;
  bool paint;
};

template <class Visit>
void for_pixels(const Disc& disc, const Visit& visit) {
  const double limit = disc.radius * disc.radius;
  for (int row = disc.top; row <= disc.bottom; ++row)
    for (int column = disc.left; column <= disc.right; ++column) {
      const double dx = column - disc.x, dy = row - disc.y;
      const double distance = (dx * dx + dy * dy) / limit;
      if (distance <= 1) visit(row, column, static_cast<float>(distance));
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

/// Darkens pixels that lie behind their neighbours, 1 where flat.
float eye_dome_light(const cv::Mat1f& depth, int row, int column, bool orthographic) {
  constexpr int reach = 3;
  constexpr float strength = 1.2F, most = 0.35F;
  const float own = depth(row, column);
  float behind = 0;
  for (const auto& [dy, dx] : {std::pair{-reach, 0}, {reach, 0}, {0, -reach}, {0, reach}}) {
    const int y = row + dy, x = column + dx;
    if (y < 0 || x < 0 || y >= depth.rows || x >= depth.cols || depth(y, x) == nothing) continue;
    const float step = orthographic ? 0.3F * (own - depth(y, x)) : std::log(own / depth(y, x));
    behind += std::clamp(step, 0.F, most);
  }
  return std::exp(-strength * behind);
}

}  // namespace

void draw_splats(cv::Mat& picture, const ViewCamera& camera, const std::vector<SplatPoint>& points) {
  const cv::Size size(picture.cols * supersampling, picture.rows * supersampling);
  const std::vector<Disc> discs = project_discs(camera, points, size);

  cv::Mat1f depth(size, nothing);
  for (const Disc& disc : discs) {
    if (disc.paint) continue;
    for_pixels(disc, [&](int row, int column, float) {
      depth(row, column) = std::min(depth(row, column), disc.depth);
    });
  }

  // Colours of the front surface blend; what lies behind it by more than its roughness is hidden.
  cv::Mat4f sum(size, cv::Vec4f::all(0));  // weighted BGR, weight
  for (const Disc& disc : discs)
    for_pixels(disc, [&](int row, int column, float distance) {
      if (std::abs(disc.depth - depth(row, column)) > roughness) return;
      const float weight = disc.share * std::exp(-4 * distance);
      const cv::Vec3f colour = disc.colour;
      sum(row, column) += weight * cv::Vec4f(colour[0], colour[1], colour[2], 1);
    });

  for (int row = 0; row < size.height; ++row)
    for (int column = 0; column < size.width; ++column) {
      cv::Vec4f& pixel = sum(row, column);
      if (pixel[3] <= 0) continue;
      const float light = eye_dome_light(depth, row, column, camera.orthographic) / pixel[3];
      pixel = cv::Vec4f(pixel[0] * light, pixel[1] * light, pixel[2] * light, 1);
    }
  cv::Mat4f layer;  // colours times coverage, coverage
  cv::resize(sum, layer, picture.size(), 0, 0, cv::INTER_AREA);
  for (int row = 0; row < picture.rows; ++row)
    for (int column = 0; column < picture.cols; ++column) {
      const cv::Vec4f& over = layer(row, column);
      cv::Vec3b& under = picture.at<cv::Vec3b>(row, column);
      for (int channel = 0; channel < 3; ++channel)
        under[channel] =
            cv::saturate_cast<uchar>(over[channel] + (1 - over[3]) * static_cast<float>(under[channel]));
    }
}

}  // namespace lcmslam
