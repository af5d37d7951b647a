#include <lcmslam/rgbd/make_cloud.hpp>

#include <cmath>
#include <stdexcept>

#include <lcmslam/cloud/coloured_cloud.hpp>

namespace lcmslam {
namespace {

const cv::Vec3b uncoloured(128, 128, 128);

// Nearest colour pixel; a pixel that contains() accepts rounds to one inside the image.
const cv::Vec3b* colour_at(const cv::Mat& colour, const cv::Vec2f& pixel) {
  if (colour.empty() || std::isnan(pixel[0])) return nullptr;
  const int u = static_cast<int>(std::floor(pixel[0] + 0.5f));
  const int v = static_cast<int>(std::floor(pixel[1] + 0.5f));
  if (u < 0 || v < 0 || u >= colour.cols || v >= colour.rows) return nullptr;
  return &colour.at<cv::Vec3b>(v, u);
}

}  // namespace

ColouredCloud make_cloud(const RgbdFrame& frame, const RegisteredDepth& registered, int step,
                         bool keep_uncoloured) {
  if (!frame.colour.empty() && frame.colour.type() != CV_8UC3)
    throw std::invalid_argument("make_cloud: the colour image must be CV_8UC3");
  const cv::Mat normals = estimate_normals(registered, step);
  ColouredCloud cloud;
  const std::size_t most = normals.total();
  cloud.points.reserve(most);
  cloud.colours.reserve(most);
  cloud.normals.reserve(most);
  cloud.sigmas.reserve(most);
  for (int v = 0; v < registered.points.rows; v += step) {
    const auto* point = registered.points.ptr<cv::Vec3f>(v);
    const auto* pixel = registered.pixels.ptr<cv::Vec2f>(v);
    const auto* sigma = registered.sigma.ptr<float>(v);
    const auto* normal = normals.ptr<cv::Vec3f>(v / step);
    for (int u = 0; u < registered.points.cols; u += step) {
      if (std::isnan(point[u][2])) continue;
      const cv::Vec3b* colour = colour_at(frame.colour, pixel[u]);
      if (!colour && !keep_uncoloured) continue;
      const cv::Vec3f& n = normal[u / step];
      cloud.points.emplace_back(point[u][0], point[u][1], point[u][2]);
      cloud.colours.push_back(colour ? *colour : uncoloured);
      cloud.normals.emplace_back(n[0], n[1], n[2]);
      cloud.sigmas.push_back(sigma[u]);
    }
  }
  return cloud;
}

}  // namespace lcmslam
