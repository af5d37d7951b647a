#include <lcmslam/fastslam/association/visibility.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr double same_view_cosine =
    0.87;                           // within 30 degrees of the last observation SURF should find it again
constexpr double same_scale = 1.5;  // and within this factor of its distance

}  // namespace

LandmarkVisibility::LandmarkVisibility(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                                       const Eigen::Isometry3d& T_world_robot)
    : frame_(frame), grid_(frame), camera_(T_world_robot * frame.T_robot_camera.translation()) {
  for (const FeaturePoint& point : points) {
    const Feature& f = frame.features[static_cast<std::size_t>(point.feature)];
    double& cell = farthest_[grid_.cell(f.x, f.y)];
    cell = std::max(cell, point.range);
  }
}

// Beyond the border nothing is measured, whatever the nearest cell shows.
bool LandmarkVisibility::is_inside(const VisibleLandmark& landmark) const {
  return landmark.x >= 0 && landmark.x < frame_.width && landmark.y >= 0 && landmark.y < frame_.height;
}

bool LandmarkVisibility::is_free(const VisibleLandmark& landmark) const {
  return is_inside(landmark) &&
         farthest_[cell(landmark)] >= 0.95 * landmark.range;  // else hidden, or unknown
}

bool LandmarkVisibility::is_hidden(const VisibleLandmark& landmark) const {
  return is_inside(landmark) && farthest_[cell(landmark)] > 0 &&
         farthest_[cell(landmark)] < 0.95 * landmark.range;
}

bool LandmarkVisibility::ought_to_show(const VisibleLandmark& landmark, const LandmarkRecord& record) const {
  if (!is_free(landmark)) return false;
  if (record.seen_at <= 0) return true;
  const Eigen::Vector3d ray = camera_ - landmark.mean;
  const double scale = ray.norm() / record.seen_at;
  return ray.normalized().dot(record.seen_from) >= same_view_cosine && scale <= same_scale &&
         scale >= 1 / same_scale;
}

}  // namespace lcmslam
