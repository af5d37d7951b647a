#include "icp/cloud_filter.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace lcmslam {
namespace {

// AnyCloud is Cloud or ColouredCloud.
template <class AnyCloud>
class Usable {
 public:
  Usable(const AnyCloud& cloud, const CloudFilterSettings& settings)
      : cloud_(cloud),
        min_range_(static_cast<float>(settings.min_range)),
        max_range_(static_cast<float>(settings.max_range)),
        max_sigma_(static_cast<float>(settings.max_sigma)),
        min_cosine_(static_cast<float>(std::cos(settings.max_incidence))) {}

  bool operator()(std::size_t i) const {
    const Eigen::Vector3f& point = cloud_.points[i];
    const Eigen::Vector3f& normal = cloud_.normals[i];
    if (!point.allFinite() || !normal.allFinite()) return false;
    const float range = point.norm();
    if (!(range >= min_range_ && range <= max_range_ && std::abs(normal.dot(point)) >= min_cosine_ * range))
      return false;
    return cloud_.sigmas.empty() || (cloud_.sigmas[i] > 0 && cloud_.sigmas[i] <= max_sigma_);
  }

 private:
  const AnyCloud& cloud_;
  float min_range_, max_range_, max_sigma_, min_cosine_;
};

// -1: nothing measured there; 0: another surface; 1: the same surface.
int continues(const cv::Vec3f& a, const cv::Vec3f& b, float noise, float tangent) {
  if (!(b[2] == b[2])) return -1;
  const Eigen::Vector3f p(a[0], a[1], a[2]);
  const Eigen::Vector3f q(b[0], b[1], b[2]);
  const float range_p = p.norm();
  const float range_q = q.norm();
  const float spacing = (p / range_p - q / range_q).norm() * std::min(range_p, range_q);
  return std::abs(range_p - range_q) <= spacing * tangent + noise ? 1 : 0;
}

}  // namespace

ColouredCloud usable_points(const ColouredCloud& cloud, const CloudFilterSettings& settings) {
  ColouredCloud result;
  if (cloud.normals.size() != cloud.size()) return result;
  const Usable<ColouredCloud> usable(cloud, settings);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!usable(i)) continue;
    result.points.push_back(cloud.points[i]);
    result.colours.push_back(cloud.colours.empty() ? cv::Vec3b(128, 128, 128) : cloud.colours[i]);
    result.normals.push_back(cloud.normals[i]);
    if (!cloud.sigmas.empty()) result.sigmas.push_back(cloud.sigmas[i]);
  }
  return result;
}

Cloud usable_points(const Cloud& cloud, const CloudFilterSettings& settings) {
  if (cloud.normals.size() != cloud.size()) return {};
  return kept_points(cloud, Usable<Cloud>(cloud, settings));
}

int remove_jump_edges(cv::Mat& points, const cv::Mat& sigma, const JumpEdgeSettings& settings, int step) {
  if (points.type() != CV_32FC3 ||
      (!sigma.empty() && (sigma.type() != CV_32FC1 || sigma.size() != points.size())))
    throw std::invalid_argument(
        "jump edges: points must be CV_32FC3, sigma empty or CV_32FC1 of the same size");
  const cv::Mat seen = points.clone();
  const auto tangent = static_cast<float>(std::tan(settings.max_incidence));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const cv::Point neighbours[4] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  int removed = 0;
  for (int v = 0; v < seen.rows; v += step)
    for (int u = 0; u < seen.cols; u += step) {
      const cv::Vec3f& p = seen.at<cv::Vec3f>(v, u);
      if (!(p[2] == p[2])) continue;
      const float noise =
          sigma.empty() ? 0
                        : static_cast<float>(settings.noise_sigmas * std::sqrt(2.0)) * sigma.at<float>(v, u);
      int same = 0;
      for (const cv::Point& side : neighbours) {
        const cv::Point q(u + side.x, v + side.y);
        if (q.x < 0 || q.y < 0 || q.x >= seen.cols || q.y >= seen.rows) continue;
        same += continues(p, seen.at<cv::Vec3f>(q), noise, tangent) == 1;
      }
      if (same >= settings.min_neighbours) continue;
      points.at<cv::Vec3f>(v, u) = cv::Vec3f(nan, nan, nan);
      ++removed;
    }
  return removed;
}

}  // namespace lcmslam
