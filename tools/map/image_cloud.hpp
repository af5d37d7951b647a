#pragma once
// A session's cloud from the images that its keyframes keep: as sharp as the depth camera saw. (The clouds
// that mappers tell are thinned to icp.keyframe_voxel, 2 cm, because the bus must bear them.)

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/map_store/file/map_file.hpp>

namespace lcmslam {

/// Every depth pixel of every keyframe that a mapper would use, in the session's map frame; one point a voxel
/// of `resolution` (m, above 0). Keyframes without images, or whose calibration nobody knows, bring the cloud
/// that was told of them. Throws StoreError as rebuild_layers().
ColouredCloud cloud_of_images(MapFile& map, std::int64_t session, double resolution);

}  // namespace lcmslam
