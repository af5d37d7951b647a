#pragma once
#include <string>

namespace lcmslam {

/// A table of a section's keys ("icp"), of those below one ("icp.coarse"), or of all (empty). Throws
/// std::invalid_argument that names the sections when there is none.
std::string list_keys(const std::string& section);

/// Everything about a key: "icp.voxel_size"; or about all that end so: "voxel_size". Throws
/// std::invalid_argument with the nearest keys when there is none.
std::string explain_key(const std::string& key);

}  // namespace lcmslam
