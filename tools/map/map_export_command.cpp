#include <fmt/format.h>
#include <iostream>
#include <set>

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/map_layers/export_navigation_grid.hpp>
#include <lcmslam/map_layers/octomap/export_octomap.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/surface/mesh_export.hpp>
#include "tools/map/image_cloud.hpp"
#include "tools/map/map_commands.hpp"
#include "tools/map/rebuilt_layers.hpp"
#include "tools/output_file.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> all_formats = {"ply", "pcd", "csv", "tum", "kitti", "mesh", "octomap", "grid"};

struct ExportOptions {
  std::string file, folder;
  std::vector<std::string> formats = all_formats;
  std::vector<std::string> sessions;  // empty: all
  double resolution = 0.02;           // m
  bool images = false;
  bool force = false;
};

std::optional<int> parse(ExportOptions& o, int argc, char** argv) {
  CLI::App app{
      "Writes a map file's sessions as files of their own: NAME_map.ply, NAME_map.pcd (clouds merged, "
      "landmarks as points), NAME_landmarks.csv, NAME_trajectory.tum, NAME_trajectory.kitti (with "
      "_times.txt); derived anew from keyframes' images: NAME_mesh.ply, .obj and .glb (mesh), NAME_space.bt "
      "(octomap), NAME_grid.pgm and .yaml (grid, as ROS's map_server reads it).",
      "lcmslam map export"};
  app.add_option("file", o.file, "an .lcmslam file")->required();
  app.add_option("folder", o.folder, "that takes the files, made where it is missing")->required();
  app.add_option("--formats", o.formats,
                 "ply, pcd, csv, tum, kitti, mesh, octomap, grid; several with commas between (all)")
      ->delimiter(',')
      ->check(CLI::IsMember(all_formats));
  app.add_option("--sessions", o.sessions, "NAMES as `map info` has them, with commas between (all)")
      ->delimiter(',');
  app.add_option("--resolution", o.resolution, "m, of merged clouds (0.02); 0: all points as they are")
      ->check(CLI::Range(0.0, 1.0));
  app.add_flag(
      "--images", o.images,
      "clouds from every pixel of the keyframes' images, at --resolution, instead of the clouds that "
      "the mapper told, which it thins (icp.keyframe_voxel)");
  app.add_flag("--force", o.force, "overwrite files that exist");
  const auto exit_code = parse_command(app, argc, argv);
  if (!exit_code && o.images && !(o.resolution > 0))
    throw std::runtime_error("--images needs a --resolution above 0");
  return exit_code;
}

class Exporter {
 public:
  explicit Exporter(const ExportOptions& options)
      : options_(options), formats_(options.formats.begin(), options.formats.end()), map_(options.file) {}

  void run() {
    const auto sessions = map_.sessions();
    const auto names = names_of(sessions);
    for (const std::string& wanted : options_.sessions)
      if (std::find(names.begin(), names.end(), wanted) == names.end())
        throw std::runtime_error(fmt::format("{}: has no session '{}'; there are {}", options_.file, wanted,
                                             fmt::join(names, ", ")));
    fs::create_directories(options_.folder);
    for (std::size_t i = 0; i < sessions.size(); ++i)
      if (is_wanted(names[i])) save(sessions[i], names[i]);
    if (!wrote_)
      throw std::runtime_error(
          fmt::format("{}: nothing was written: what was asked for has nothing for {}; "
                      "`lcmslam map info` says what is in it",
                      options_.file, fmt::join(options_.formats, ", ")));
  }

 private:
  bool is_wanted(const std::string& name) const {
    const auto& names = options_.sessions;
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
  }

  void save(const StoredSession& session, const std::string& name) {
    const SessionCounts counts = map_.counts(session.id);
    const bool has_cloud = counts.clouds > 0 || (options_.images && counts.images > 0);
    if (has_cloud && (wants("ply") || wants("pcd"))) {
      save_points(name, merged(session.id, counts.images > 0));
    }
    if (counts.landmarks > 0) {
      const auto landmarks = map_.landmarks(session.id);
      save_points(name, landmarks);
      if (wants("csv"))
        write({name + "_landmarks.csv"}, [&](const fs::path& file) { save_csv(file, landmarks); });
    }
    save_trajectory(session, name);
    if (counts.images > 0 && (wants("mesh") || wants("octomap") || wants("grid")))
      save_derived(session, name);
  }

  ColouredCloud merged(std::int64_t session, bool has_images) {
    if (options_.images && has_images) return cloud_of_images(map_, session, options_.resolution);
    const DenseMap dense = map_.dense_map(session);
    return options_.resolution > 0 ? dense.merge(options_.resolution) : dense.merge_all();
  }

  template <class Points>
  void save_points(const std::string& name, const Points& points) {
    if (wants("ply")) write({name + "_map.ply"}, [&](const fs::path& file) { save_ply(file, points); });
    if (wants("pcd")) write({name + "_map.pcd"}, [&](const fs::path& file) { save_pcd(file, points); });
  }

  void save_trajectory(const StoredSession& session, const std::string& name) {
    Trajectory trajectory;
    for (const StoredPose& pose : map_.trajectory(session.id))
      trajectory.push_back({pose.utime, pose.T_map_robot});
    if (trajectory.empty()) return;
    sort_trajectory(trajectory);
    if (wants("tum"))
      write({name + "_trajectory.tum"}, [&](const fs::path& file) {
        save_tum(file, trajectory, {session.frame, "robot"});
      });
    if (wants("kitti"))
      write({name + "_trajectory.kitti", name + "_trajectory_times.txt"},
            [&](const fs::path& file) { save_kitti(file, trajectory); });
  }

  void save_derived(const StoredSession& session, const std::string& name) {
    const auto layers = rebuild_layers(map_, session.id);
    if (wants("mesh")) {
      const Mesh mesh = layers->settled_mesh();
      for (const char* ending : {".ply", ".obj", ".glb"})
        write({name + "_mesh" + ending}, [&](const fs::path& file) { save_mesh(file, mesh); });
    }
    const OccupancyGrid space = layers->space().copy();
    if (wants("octomap"))
      write({name + "_space.bt"}, [&](const fs::path& file) { save_octomap(file, space); });
    const auto path = map_.trajectory(session.id);
    if (!wants("grid") || path.empty()) return;
    const Eigen::Isometry3d& T_map_robot = path.back().T_map_robot;
    const NavigationSettings all = reaching_all(space, layers->settings().navigation, T_map_robot);
    const auto stood = robot_places(session.id);
    write({name + "_grid.yaml", name + "_grid.pgm"}, [&](const fs::path&) {
      save_navigation_grid(HeldFolder(options_.folder), name + "_grid",
                           make_navigation_grid(space, all, T_map_robot, stood));
    });
  }

  /// By its keyframes: they stand where the graph has them at last.
  std::vector<Eigen::Vector3d> robot_places(std::int64_t session) {
    const std::vector<StoredKeyframe> keyframes = map_.keyframes(session);
    const Eigen::Isometry3d T_camera_robot =
        calibration_of(map_, session, keyframes).T_robot_camera.inverse();
    std::vector<Eigen::Vector3d> places;
    for (const StoredKeyframe& keyframe : keyframes)
      places.emplace_back((keyframe.T_map_camera * T_camera_robot).translation());
    return places;
  }

  bool wants(const std::string& format) const { return formats_.count(format) > 0; }

  /// `save` is given the first one's path; they are told when they are there.
  template <class Save>
  void write(const std::vector<std::string>& names, const Save& save) {
    const fs::path folder = options_.folder;
    for (const std::string& name : names) check_output_file(folder / name, options_.force);
    save(folder / names.front());
    for (const std::string& name : names) std::cout << (folder / name).string() << "\n";
    wrote_ = true;
  }

  ExportOptions options_;
  std::set<std::string> formats_;
  MapFile map_;
  bool wrote_ = false;
};

}  // namespace

int map_export_command(int argc, char** argv) {
  ExportOptions options;
  if (const auto exit_code = parse(options, argc, argv)) return *exit_code;
  Exporter(options).run();
  return 0;
}

}  // namespace lcmslam
