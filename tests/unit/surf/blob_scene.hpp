#pragma once
// Images with a known answer: sums of Gaussians, drawn exactly under any similarity transform.

#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/geometry/random.hpp>

namespace lcmslam::test {

struct Gaussian {
  double x, y;              // centre
  double sigma_u, sigma_v;  // along its own axes, pixels
  double angle;             // of the u axis, radians clockwise
  double amplitude;         // grey values
};

// p_image = scale * R(angle) * p_scene + (x, y), y down.
struct Similarity {
  double scale = 1, angle = 0, x = 0, y = 0;

  cv::Point2d operator()(double px, double py) const {
    const double c = scale * std::cos(angle), s = scale * std::sin(angle);
    return {c * px - s * py + x, s * px + c * py + y};
  }
};

struct BlobScene {
  std::vector<Gaussian> blobs;
  double background = 128;

  cv::Mat_<double> draw_exact(int width, int height, const Similarity& map = {}) const {
    cv::Mat_<double> image(height, width, background);
    for (const Gaussian& blob : blobs) {
      const cv::Point2d centre = map(blob.x, blob.y);
      const double u = map.scale * blob.sigma_u, v = map.scale * blob.sigma_v;
      const double c = std::cos(blob.angle + map.angle), s = std::sin(blob.angle + map.angle);
      const int reach = static_cast<int>(std::ceil(5 * std::max(u, v)));
      const int column = static_cast<int>(centre.x), row = static_cast<int>(centre.y);
      for (int y = std::max(0, row - reach); y <= std::min(height - 1, row + reach); ++y)
        for (int x = std::max(0, column - reach); x <= std::min(width - 1, column + reach); ++x) {
          const double dx = x - centre.x, dy = y - centre.y;
          const double along = (c * dx + s * dy) / u, across = (-s * dx + c * dy) / v;
          image(y, x) += blob.amplitude * std::exp(-0.5 * (along * along + across * across));
        }
    }
    return image;
  }

  cv::Mat draw(int width, int height, const Similarity& map = {}, double gain = 1, double offset = 0) const {
    cv::Mat grey;
    draw_exact(width, height, map).convertTo(grey, CV_8U, gain, offset);
    return grey;
  }
};

// Blobs of all sizes and shapes over -extent..extent, centred on the origin.
inline BlobScene random_scene(std::uint64_t seed, double extent, int count = 400) {
  Random random(seed);
  BlobScene scene;
  for (int i = 0; i < count; ++i) {
    const double sigma = 2 * std::exp(random.uniform(0, 1.8));
    scene.blobs.push_back({random.uniform(-extent, extent), random.uniform(-extent, extent), sigma,
                           sigma * random.uniform(0.5, 1), random.uniform(0, 2 * M_PI),
                           random.uniform(15, 45) * (random.uniform() < 0.5 ? -1 : 1)});
  }
  return scene;
}

}  // namespace lcmslam::test
