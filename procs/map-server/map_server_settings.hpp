#pragma once
#include <filesystem>

#include <lcmslam/settings/settings.hpp>
#include "procs/map-server/layer_settings.hpp"
#include "procs/map-server/page/page_settings.hpp"

namespace lcmslam {

/// Section `map-server`.
struct MapServerSettings {
  std::filesystem::path folder = "out/maps";
  std::string store = "map.lcmslam";
  std::string mode = "map";
  std::filesystem::path map;
  double resolution = 0.02;
  double snapshot_period = 60;
  int export_folders = 20;
  int max_sessions = 16;
  int max_landmarks = 300'000;
  int max_keyframes = 10'000;
  int max_points = 20'000'000;
  int max_incomplete = 32;
  int max_path = 100'000;
  bool places = true;
  LayerSettings layers;
  PageSettings page;

  void describe(SettingsVisitor& s) {
    s.path("folder", folder, "that takes the maps");
    s.text(
        "store", store,
        "name in that folder of the file that all is written into as it arrives (lcmslam map); one that is "
        "there is gone on with; empty: none");
    s.require(store.find('/') == std::string::npos && store.substr(0, 1) != ".", "store",
              "must be the name of a file, without a folder and without a dot in front");
    s.choice(
        "mode", mode, {"map", "localise"},
        "map: what comes is written into the store; localise: nothing is, and the robot is found in `map`");
    s.path("map", map, "file of a map that is only read, in which the robot is found (localise)");
    s.require((mode == "localise") != map.empty(), "map", "must name a map in mode localise, and only there");
    s.number("resolution", resolution, "m", {0, 1}, "of the merged dense map; 0: its points as they came");
    s.number("snapshot_period", snapshot_period, "s", {0, 3600},
             "between two savings of maps that changed as files (PLY, PCD, poses), more where saving takes "
             "long; 0: only at the end. Without a `store` a kill leaves nothing newer");
    s.number("export_folders", export_folders, "", {0, 10'000},
             "below the folder of the maps that requests may make");
    s.number(
        "max_sessions", max_sessions, "", {2, 1000},
        "maps of each mapper in memory: it begins another when it restarts, is reset, or time begins anew. "
        "Those that it has left go from here once the map's file has them");
    s.number("max_landmarks", max_landmarks, "", {1, 1e8}, "of a map");
    s.number("max_keyframes", max_keyframes, "", {1, 1e7}, "of a map");
    s.number("max_points", max_points, "", {1000, 1e9}, "of a map's keyframes together (31 bytes each)");
    s.number("max_incomplete", max_incomplete, "", {1, 10000},
             "keyframes of a map that wait for tiles; then the oldest is given up and asked for again");
    s.number("max_path", max_path, "", {10, 1e8}, "poses of a path; then every second one goes");
    s.flag(
        "places", places,
        "keyframes are remembered by what they look like: by them sessions find each other, and who is lost "
        "his place");
    s.require(places || mode == "map", "places", "must be true in mode localise");
    s.section("layers", layers, "maps that are derived from the camera's images, and answer questions");
    s.section("page", page, "what an operator sees in a browser, live (docs/LIVE_PAGE.md)");
  }
};

}  // namespace lcmslam
