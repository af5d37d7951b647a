#include "tools/map/image_cloud.hpp"

#include <lcmslam/cloud/cloud.hpp>
#include <lcmslam/cloud/cloud_filter.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include "tools/map/rebuilt_layers.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t worth_merging = 4'000'000;  // points (31 bytes each) that may wait

}  // namespace

ColouredCloud cloud_of_images(MapFile& map, std::int64_t session, double resolution) {
  const auto keyframes = map.keyframes(session);
  const RgbdCalibration calibration = calibration_of(map, session, keyframes);
  const DepthRegistration registration(calibration);
  DepthFilter filter(calibration);
  ColouredCloud all;
  for (const StoredKeyframe& keyframe : keyframes) {
    ColouredCloud seen;
    if (const auto images = map.images(session, keyframe.id)) {
      RgbdFrame frame = decode_images(images->frame, calibration);
      filter(frame.depth, frame.amplitude);
      seen = usable_points(make_cloud(frame, registration(frame, images->T_colour_depth_time)));
    } else if (auto told = map.cloud(session, keyframe.id)) {
      seen = std::move(*told);
    }
    if (seen.size() == 0) continue;
    append(transformed(seen, keyframe.T_map_camera), all);
    if (all.size() > worth_merging) all = voxel_filtered(all, resolution);
  }
  return voxel_filtered(all, resolution);
}

}  // namespace lcmslam
