#pragma once
// What is derived of a map, made anew from its file.

#include <map>
#include <memory>

#include <lcmslam/live_map/live_map.hpp>
#include <lcmslam/map_store/file/map_file.hpp>

namespace lcmslam {

/// By which the first images of a session's keyframes were taken; the file's only one where nothing says
/// which. Throws StoreError where that is not one.
RgbdCalibration calibration_of(MapFile& map, std::int64_t session,
                               const std::vector<StoredKeyframe>& keyframes);

/// Of a dense session: from its keyframes' images, or from the cloud of those without, and of those of which
/// nobody knows by which calibration they were taken. Throws StoreError where something cannot be read, and
/// where the file has no calibration of the camera. A surface that takes more than half of the machine's
/// memory is not whole, which is said on standard error.
std::unique_ptr<LiveMap> rebuild_layers(MapFile& map, std::int64_t session);

/// Of several, each where it lies in the map (T_map_session by session).
using PlacedSessions = std::map<std::int64_t, Eigen::Isometry3d>;
std::unique_ptr<LiveMap> rebuild_layers(MapFile& map, const PlacedSessions& sessions);

}  // namespace lcmslam
