#pragma once
// What is derived of a map, made anew from its file.

#include <memory>

#include <lcmslam/live_map/live_map.hpp>
#include <lcmslam/map_store/file/map_file.hpp>

namespace lcmslam {

/// Of a dense session: from its keyframes' images, or from the cloud of those without. Throws StoreError
/// where something cannot be read, and where the file has no calibration of the camera.
std::unique_ptr<LiveMap> rebuild_layers(MapFile& map, std::int64_t session);

}  // namespace lcmslam
