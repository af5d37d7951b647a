#include <lcmslam/cloud/cloud_filter.hpp>

#include <cmath>

#include <lcmslam/cloud/coloured_cloud.hpp>

namespace lcmslam {
namespace {

// AnyCloud is Cloud or ColouredCloud.
template <class AnyCloud>
class Usable {
 public:
  Usable(const AnyCloud& cloud, const CloudFilterSettings& settings)
      : cloud_(cloud),
        normals_(settings.normals),
        min_range_(static_cast<float>(settings.min_range)),
        max_range_(static_cast<float>(settings.max_range)),
        max_sigma_(static_cast<float>(settings.max_sigma)),
        min_cosine_(static_cast<float>(std::cos(settings.max_incidence))) {}

  bool operator()(std::size_t i) const {
    const Eigen::Vector3f& point = cloud_.points[i];
    if (!point.allFinite()) return false;
    const float range = point.norm();
    if (!(range >= min_range_ && range <= max_range_)) return false;
    if (has_normal(i) ? is_grazing(i, range) : normals_) return false;
    return cloud_.sigmas.empty() || (cloud_.sigmas[i] > 0 && cloud_.sigmas[i] <= max_sigma_);
  }

 private:
  bool has_normal(std::size_t i) const { return !cloud_.normals.empty() && cloud_.normals[i].allFinite(); }
  bool is_grazing(std::size_t i, float range) const {
    return !(std::abs(cloud_.normals[i].dot(cloud_.points[i])) >= min_cosine_ * range);
  }

  const AnyCloud& cloud_;
  bool normals_;
  float min_range_, max_range_, max_sigma_, min_cosine_;
};

}  // namespace

ColouredCloud usable_points(const ColouredCloud& cloud, const CloudFilterSettings& settings) {
  ColouredCloud result;
  const Usable<ColouredCloud> usable(cloud, settings);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!usable(i)) continue;
    result.points.push_back(cloud.points[i]);
    result.colours.push_back(cloud.colours.empty() ? cv::Vec3b(128, 128, 128) : cloud.colours[i]);
    if (!cloud.normals.empty()) result.normals.push_back(cloud.normals[i]);
    if (!cloud.sigmas.empty()) result.sigmas.push_back(cloud.sigmas[i]);
  }
  return result;
}

Cloud usable_points(const Cloud& cloud, const CloudFilterSettings& settings) {
  return kept_points(cloud, Usable<Cloud>(cloud, settings));
}

}  // namespace lcmslam
