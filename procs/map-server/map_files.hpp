#pragma once
// The files of both maps: PLY, PCD and pictures, of landmark maps and dense maps.

#include <chrono>
#include <functional>
#include <future>
#include <string>
#include <vector>

#include <lcmslam/files/held_folder.hpp>
#include <lcmslam/live_map/live_map.hpp>
#include <lcmslam/map_store/dense_map.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include "procs/map-server/map_recorder.hpp"

namespace lcmslam {

/// All maps as they are at one moment, for whoever has the time to write them.
struct MapsToSave {
  using Path = std::vector<Eigen::Vector3d>;  ///< the robot's, m
  struct Landmarks {
    std::string name;
    std::vector<Landmark> landmarks;
    Path path;
  };
  struct Dense {
    std::string name;
    DenseMap map;
    Path path;
    bool is_live = false;  ///< `live` below is derived of it
  };
  std::vector<Landmarks> landmarks;
  std::vector<Dense> dense;
  std::filesystem::path store;                   ///< the map's file
  std::vector<KeptSession> kept;                 ///< of that file, to be read when it is their turn
  double resolution = 0.02;                      ///< m, of merged dense maps
  std::shared_ptr<const LiveMap> live;           ///< what is derived of the current dense map; may be null
  std::optional<Eigen::Isometry3d> T_map_robot;  ///< the newest, from where the ground is followed,
  std::vector<Eigen::Vector3d> also_stood;       ///< and from where it was at its keyframes, m
};

/// NAME_map.ply, NAME_map.pcd, NAME_front.png, NAME_top.png of each map; of what is derived icp_mesh.ply and
/// icp_mesh.glb ("mesh"), icp_space.bt ("octomap"), icp_grid.pgm and icp_grid.yaml ("grid"). `formats`:
/// "ply", "pcd", "png", "mesh", "octomap", "grid", several separated by commas; empty: all. Gives the files'
/// paths. Throws std::runtime_error for other formats and for the first file that cannot be written.
std::vector<std::string> save_maps(const MapsToSave& maps, const HeldFolder& folder,
                                   const std::string& formats);

/// Writes maps in a thread of its own, so that nothing waits for the disk. Used by one thread.
class BackgroundSaver {
 public:
  /// How a saving ended.
  struct Outcome {
    std::int64_t revision = 0;
    std::vector<std::string> files;  ///< that were written
    std::string error;               ///< empty: all was saved
    std::chrono::duration<double> took{};
  };

  bool busy() const { return saving_.valid(); }
  /// Begins to write these formats (save_maps()) into the folder, which is made where it is missing. Not
  /// while it is busy.
  void begin(MapsToSave maps, const std::filesystem::path& folder, std::int64_t revision,
             const std::string& formats = "ply,pcd");
  /// The same, into a folder that is there.
  void begin(MapsToSave maps, const HeldFolder& folder, std::int64_t revision, const std::string& formats);
  /// How what was begun ended; nothing while it goes on (`wait`: only when nothing was begun).
  std::optional<Outcome> take_outcome(bool wait);

 private:
  using Folder = std::function<HeldFolder()>;
  void begin_in(MapsToSave maps, const Folder& folder, std::int64_t revision, const std::string& formats);

  std::future<Outcome> saving_;  // its destructor waits
};

}  // namespace lcmslam
