#pragma once
#include <filesystem>

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Section `map-server`.
struct MapServerSettings {
  std::filesystem::path folder = "out/maps";
  double resolution = 0.02;

  void describe(SettingsVisitor& s) {
    s.path("folder", folder, "that takes the maps");
    s.number("resolution", resolution, "m", {0.001, 1}, "of the merged dense map");
  }
};

}  // namespace lcmslam
