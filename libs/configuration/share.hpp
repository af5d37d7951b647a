#pragma once
// Where the files lie that programs read: config/, logs/, java/.

#include <filesystem>

namespace lcmslam {

/// Root of them: $LCMSLAM_SHARE, or else ../share/lcmslam beside the folder of the running program, in the
/// build tree (links to the source) as after install. Programs of others that link a library of ours set the
/// variable.
std::filesystem::path share_folder();

/// share_folder() / `name`, with links resolved, so that messages name the file that one would edit. Throws
/// ConfigError where there is no such file or folder.
std::filesystem::path share_path(const std::filesystem::path& name);

}  // namespace lcmslam
