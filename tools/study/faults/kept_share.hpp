#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace lcmslam {

/// Share of the points of `before` (PCD) that have a neighbour within 0.1 m in one of the maps called like
/// `map` in `folder` or below it (each session has its own); 1 when nothing was mapped before, 0 without any
/// file after.
std::optional<double> kept_share(const std::filesystem::path& before, const std::filesystem::path& folder,
                                 const std::string& map);

}  // namespace lcmslam
