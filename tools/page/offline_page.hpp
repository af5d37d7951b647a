#pragma once
// The page as one file that opens offline, with what it shows inside.

#include <filesystem>
#include <string>

#include <lcmslam/web/board.hpp>

namespace lcmslam {

/// index.html of `folder` with its script, its style and all of the board's messages inside. Throws
/// std::runtime_error that names what is missing.
std::string offline_page(const std::filesystem::path& folder, const Board& board);

}  // namespace lcmslam
