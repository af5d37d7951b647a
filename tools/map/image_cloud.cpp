#include "tools/map/image_cloud.hpp"

#include <limits>

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/stored_calibration.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t worth_merging = 4'000'000;  // points (31 bytes each) that may wait

/// Reads images, each by the calibration that it was taken by.
class ImageReader {
 public:
  ColouredCloud points(const StoredImages& images) {
    if (!head_ || head_->bytes != images.calibration->bytes) head_.emplace(*images.calibration);
    RgbdFrame frame = decode_images(images.frame, head_->calibration);
    head_->filter(frame.depth, frame.amplitude);
    return usable_points(make_cloud(frame, head_->registration(frame, images.T_colour_depth_time)));
  }

 private:
  struct Head {
    explicit Head(const StoredCalibration& stored)
        : bytes(stored.bytes),
          calibration(from_stored(stored)),
          registration(calibration),
          filter(calibration) {}
    std::vector<std::uint8_t> bytes;
    RgbdCalibration calibration;
    DepthRegistration registration;
    DepthFilter filter;
  };
  std::optional<Head> head_;  // of the last images
};

/// What was told of a keyframe has no sigmas and may have no normals: such normals become unknown (NaN), and
/// where some points have no sigma all count alike.
void append_any(ColouredCloud more, ColouredCloud& cloud) {
  if (cloud.size() > 0 && more.size() > 0) {
    const Eigen::Vector3f unknown = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    if (!more.normals.empty() || !cloud.normals.empty())
      for (ColouredCloud* either : {&more, &cloud}) either->normals.resize(either->size(), unknown);
    if (more.sigmas.empty() || cloud.sigmas.empty())
      for (ColouredCloud* either : {&more, &cloud}) either->sigmas.clear();
  }
  append(more, cloud);
}

}  // namespace

ColouredCloud cloud_of_images(MapFile& map, std::int64_t session, double resolution) {
  ImageReader reader;
  ColouredCloud all;
  for (const StoredKeyframe& keyframe : map.keyframes(session)) {
    ColouredCloud seen;
    if (const auto images = map.images(session, keyframe.id); images && images->calibration) {
      seen = reader.points(*images);
    } else if (auto told = map.cloud(session, keyframe.id)) {
      seen = std::move(*told);
    }
    if (seen.size() == 0) continue;
    append_any(transformed(seen, keyframe.T_map_camera), all);
    if (all.size() > worth_merging) all = voxel_filtered(all, resolution);
  }
  return voxel_filtered(all, resolution);
}

}  // namespace lcmslam
