#include <lcmslam/registration/image_overlap.hpp>

namespace lcmslam {

const Segment* ImageOverlap::at(double x, double y) const {
  if (!(x >= 0 && y >= 0 && x < size_.width && y < size_.height)) return nullptr;
  const cv::Point pixel(static_cast<int>(x), static_cast<int>(y));
  for (const Segment& segment : segments_)
    if (segment.area.contains(pixel)) return &segment;
  return nullptr;
}

std::optional<double> ImageOverlap::overlap() const {
  int known = 0, overlapping = 0;
  for (const Segment& segment : segments_) {
    known += segment.state != SegmentState::unknown ? 1 : 0;
    overlapping += segment.state == SegmentState::overlapping ? 1 : 0;
  }
  if (known == 0) return std::nullopt;
  return static_cast<double>(overlapping) / known;
}

bool may_overlap(const Eigen::Vector3d& point, const ImageOverlap& overlap, const CameraModel& camera) {
  const auto pixel = camera.project(point);
  const Segment* segment = pixel ? overlap.at(pixel->x() + 0.5, pixel->y() + 0.5) : nullptr;
  return segment != nullptr && segment->state != SegmentState::outside;
}

Cloud overlapping_points(const Cloud& cloud, const ImageOverlap& overlap, const CameraModel& camera,
                         const Eigen::Isometry3d& T_camera_cloud) {
  return kept_points(cloud, [&](std::size_t i) {
    return may_overlap(T_camera_cloud * cloud.points[i].cast<double>(), overlap, camera);
  });
}

}  // namespace lcmslam
