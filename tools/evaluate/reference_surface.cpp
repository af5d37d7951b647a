#include "tools/evaluate/reference_surface.hpp"

#include <cmath>
#include <optional>
#include <stdexcept>

#include <lcmslam/camera_calibration_t.hpp>
#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/rgbd/depth_view.hpp>
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

constexpr double voxel_size = 0.01;  // m
constexpr int pixel_step = 1;

VoxelMapSettings fine_map() {
  VoxelMapSettings settings;
  settings.voxel_size = voxel_size;
  settings.max_blocks = 4'000'000;
  return settings;
}

}  // namespace

ReferenceSurface::ReferenceSurface(const std::string& log, const Trajectory& truth, bool of_camera,
                                   double clock_offset)
    : map_(fine_map()) {
  const Utime offset = std::llround(1e6 * clock_offset);
  auto reader = MessageReader::of_all(log);
  std::optional<DepthRegistration> registration;
  while (const auto event = reader.next()) {
    RgbdFrame frame;
    try {
      if (event->channel == "CAMERA_CALIBRATION" && !registration)
        registration.emplace(from_message(decode_message<camera_calibration_t>(event->data, event->size)));
      if (event->channel != "CAMERA" || !registration) continue;
      frame = decode_images(decode_message<images_t>(event->data, event->size), registration->calibration());
    } catch (const DecodeError&) {
      ++refused_;
      continue;
    }
    const RgbdCalibration& calibration = registration->calibration();
    const auto T_world_body = pose_at(truth, calibration.depth_time(frame.depth_utime) + offset);
    if (!T_world_body) continue;
    const DepthView view = DepthPoints(calibration).thinned(frame, pixel_step);
    Cloud cloud = usable_points(cloud_of(view, Eigen::Isometry3d::Identity(), Vector6d::Zero()));
    const Eigen::Isometry3d T_world_camera =
        of_camera ? *T_world_body : *T_world_body * calibration.T_robot_camera;
    move(cloud, T_world_camera);
    map_.insert(cloud, T_world_camera);
    ++frames_;
  }
  if (frames_ == 0)
    throw std::runtime_error(log + ": no CAMERA images with a calibration at times where the truth is known");
}

float ReferenceSurface::distance(const Eigen::Vector3f& point, float reach) const {
  TargetPoint found;
  if (!map_.find(point, reach, found)) return reach;
  const Eigen::Vector3f offset = point - found.point;
  const float height = std::abs(found.normal.dot(offset));
  const float beside = std::sqrt(std::max(0.0f, offset.squaredNorm() - height * height));
  return beside < 3 * static_cast<float>(voxel_size) ? height : offset.norm();
}

}  // namespace lcmslam
