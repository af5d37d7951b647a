#include "tools/map/rebuilt_layers.hpp"

#include <unistd.h>
#include <algorithm>
#include <iostream>

#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/stored_calibration.hpp>

namespace lcmslam {

RgbdCalibration calibration_of(MapFile& map, std::int64_t session,
                               const std::vector<StoredKeyframe>& keyframes) {
  for (const StoredKeyframe& keyframe : keyframes) {
    const auto images = map.images(session, keyframe.id);
    if (images && images->calibration) return from_stored(*images->calibration);
  }
  const std::vector<StoredCalibration> known = map.calibrations();
  if (known.size() != 1)
    map.database().fail(std::to_string(known.size()) + " calibrations fit the keyframes of session " +
                        std::to_string(session) + ", and one is needed to derive anything from them");
  return from_stored(known[0]);
}

namespace {

/// MB. A robot shares its memory with much else and keeps what is near; who asks for a map wants all of it.
double half_of_memory() {
  return 0.5e-6 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

}  // namespace

std::unique_ptr<LiveMap> rebuild_layers(MapFile& map, std::int64_t session) {
  return rebuild_layers(map, PlacedSessions{{session, Eigen::Isometry3d::Identity()}});
}

std::unique_ptr<LiveMap> rebuild_layers(MapFile& map, const PlacedSessions& sessions) {
  const std::int64_t first = sessions.begin()->first;
  const RgbdCalibration calibration = calibration_of(map, first, map.keyframes(first));
  LiveMapSettings settings;
  settings.background = false;
  settings.surface.min_looks = 0.02;  // most surfaces were seen by one keyframe alone
  settings.surface.memory = std::max(settings.surface.memory, half_of_memory());
  KnownCalibrations known;
  auto layers = std::make_unique<LiveMap>(known.same_as(calibration), settings);
  int number = 0;
  for (const auto& [session, T_map_session] : sessions)
    for (const StoredKeyframe& keyframe : map.keyframes(session)) {
      const Eigen::Isometry3d T_map_camera = T_map_session * keyframe.T_map_camera;
      const auto images = map.images(session, keyframe.id);
      if (const auto taken_by = images ? known.of(*images) : nullptr) {
        layers->look_through(taken_by);
        layers->keep(number++, decode_images(images->frame, *taken_by),
                     {T_map_camera, images->T_colour_depth_time});
      } else if (const auto cloud = map.cloud(session, keyframe.id)) {
        layers->keep(number++, *cloud, T_map_camera);
      }
    }
  layers->settle();
  if (layers->surface_gave_way())
    std::cerr
        << "the surface takes more than half of this machine's memory: what lies farthest from the last "
           "keyframe is not in it\n";
  return layers;
}

}  // namespace lcmslam
