#pragma once
#include <filesystem>

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Section `map-server`.
struct MapServerSettings {
  std::filesystem::path folder = "out/maps";
  double resolution = 0.02;
  double snapshot_period = 20;
  int export_folders = 20;

  void describe(SettingsVisitor& s) {
    s.path("folder", folder, "that takes the maps");
    s.number("resolution", resolution, "m", {0.001, 1}, "of the merged dense map");
    s.number("snapshot_period", snapshot_period, "s", {0, 3600},
             "between two savings of what changed while mapping; 0: only at the end");
    s.number("export_folders", export_folders, "", {0, 10'000},
             "below the folder of the maps that requests may make");
  }
};

}  // namespace lcmslam
