#pragma once
// Room for a map file in the place of another one.

#include <filesystem>

namespace lcmslam {

/// Before another file takes the place of this one: what SQLite has left beside it (the log of a process that
/// was killed) goes, or else SQLite would write that over the new file. An old map has all of it then. Throws
/// StoreError while somebody has the old one open.
void clear_beside(const std::filesystem::path& file);

}  // namespace lcmslam
