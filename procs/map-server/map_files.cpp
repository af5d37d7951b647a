#include "procs/map-server/map_files.hpp"

#include <set>
#include <sstream>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/map_layers/export_navigation_grid.hpp>
#include <lcmslam/map_layers/octomap/export_octomap.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/messages/print_message.hpp>
#include <lcmslam/rendering/map_picture.hpp>
#include <lcmslam/surface/mesh_export.hpp>

namespace lcmslam {
namespace {

const cv::Vec3b path_colour(40, 40, 220);  // BGR

PictureRequest request(MapView view, const std::string& title, const MapsToSave::Path& path) {
  PictureRequest r;
  r.view = view;
  r.title = title;
  if (!path.empty()) r.paths.push_back({"robot", path_colour, path});
  return r;
}

std::set<std::string> read_formats(const std::string& formats) {
  const std::set<std::string> known = {"ply", "pcd", "png", "mesh", "octomap", "grid"};
  std::set<std::string> wanted;
  std::istringstream text(formats);
  for (std::string format; std::getline(text, format, ',');) {
    if (known.count(format) == 0)
      throw std::runtime_error("format '" + printable(format.substr(0, 20)) +
                               "' is none of ply, pcd, png, mesh, octomap, grid");
    wanted.insert(format);
  }
  return wanted.empty() ? known : wanted;
}

class MapFiles {
 public:
  MapFiles(const HeldFolder& folder, const std::string& formats)
      : folder_(folder), formats_(read_formats(formats)) {}

  template <class Map>
  void save_points(const std::string& name, const Map& map) {
    if (wants("ply")) save_ply(file(name + "_map.ply"), map);
    if (wants("pcd")) save_pcd(file(name + "_map.pcd"), map);
  }

  void save_derived(const LiveMap& live, const std::optional<Eigen::Isometry3d>& T_map_robot,
                    const std::vector<Eigen::Vector3d>& also_stood) {
    if (wants("mesh")) {
      save_mesh_ply(file("icp_mesh.ply"), mesh(live));
      save_mesh_glb(file("icp_mesh.glb"), mesh(live));
    }
    if (!wants("octomap") && !wants("grid")) return;
    const OccupancyGrid space = live.space().copy();
    if (wants("octomap")) save_octomap(file("icp_space.bt"), space);
    if (!wants("grid") || !T_map_robot) return;
    const NavigationSettings all = reaching_all(space, live.settings().navigation, *T_map_robot);
    save_navigation_grid(folder_, "icp_grid", make_navigation_grid(space, all, *T_map_robot, also_stood));
    file("icp_grid.pgm");
    file("icp_grid.yaml");
  }

  void save_pictures(const MapsToSave::Landmarks& map) {
    const std::string title = "FastSLAM: " + std::to_string(map.landmarks.size()) + " landmarks";
    save_pictures(map.name, title, map.path, [&](PictureRequest& r) { r.landmarks = &map.landmarks; });
  }

  void save_pictures(const MapsToSave::Dense& map, const ColouredCloud& cloud, double resolution) {
    const std::string title = "6-D SLAM: " + std::to_string(cloud.size()) + " points";
    save_pictures(map.name, title, map.path, [&](PictureRequest& r) {
      r.cloud = &cloud;
      if (resolution > 0) r.resolution = resolution;
    });
  }

  /// Of the surface, coloured as the images of the keyframes are. False: there is none.
  bool save_pictures(const MapsToSave::Dense& map, const LiveMap& live) {
    constexpr double finest = 0.005;  // m
    if (!wants("png")) return false;
    if (mesh(live).vertices.empty()) return false;
    const ColouredCloud surface{mesh(live).vertices, mesh(live).colours, mesh(live).normals, {}};
    const ColouredCloud seen = live.cloud(finest);
    const std::string title = "6-D SLAM: " + std::to_string(mesh(live).triangles.size()) + " triangles";
    save_pictures(map.name, title, map.path, [&](PictureRequest& r) {
      r.cloud = &surface;
      r.paint = &seen;
      r.resolution = finest;
    });
    return true;
  }

  const std::vector<std::string>& written() const { return written_; }

 private:
  bool wants(const std::string& format) const { return formats_.count(format) > 0; }

  FilePlace file(const std::string& name) {
    const FilePlace place(folder_, name);
    written_.push_back(place.path().string());
    return place;
  }

  template <class Fill>
  void save_pictures(const std::string& name, const std::string& title, const MapsToSave::Path& path,
                     const Fill& fill) {
    if (!wants("png")) return;
    for (const auto& [view, suffix] :
         {std::pair(MapView::front, "_front.png"), std::pair(MapView::top, "_top.png")}) {
      PictureRequest r = request(view, title, path);
      fill(r);
      save_picture(file(name + suffix), draw_map(r));
    }
  }

  /// Put together once, for its files and for the pictures of it.
  const Mesh& mesh(const LiveMap& live) {
    if (!mesh_) mesh_ = live.settled_mesh();
    return *mesh_;
  }

  HeldFolder folder_;
  std::set<std::string> formats_;
  std::optional<Mesh> mesh_;
  std::vector<std::string> written_;
};

void save_kept(const KeptSession& kept, MapFile& file, double resolution, MapFiles& files) {
  if (kept.mapper == "fastslam") {
    const MapsToSave::Landmarks map{kept.name, file.landmarks(kept.id), {}};
    files.save_points(map.name, map.landmarks);
    files.save_pictures(map);
  } else {
    const MapsToSave::Dense map{kept.name, file.dense_map(kept.id), {}, false};
    const ColouredCloud cloud = map.map.merge(resolution);
    files.save_points(map.name, cloud);
    files.save_pictures(map, cloud, resolution);
  }
}

/// One at a time, so that no more of them than that is in memory. One that is damaged takes no other away.
void save_kept(const MapsToSave& maps, MapFiles& files) {
  if (maps.kept.empty()) return;
  MapFile file(maps.store);
  std::optional<StoreError> damage;
  for (const KeptSession& kept : maps.kept) try {
      save_kept(kept, file, maps.resolution, files);
    } catch (const StoreError& error) {
      if (!damage) damage = error;
    }
  if (damage) throw StoreError(*damage);
}

}  // namespace

std::vector<std::string> save_maps(const MapsToSave& maps, const HeldFolder& folder,
                                   const std::string& formats) {
  MapFiles files(folder, formats);
  std::vector<ColouredCloud> clouds;
  for (const MapsToSave::Landmarks& map : maps.landmarks) files.save_points(map.name, map.landmarks);
  for (const MapsToSave::Dense& map : maps.dense) {
    clouds.push_back(map.map.merge(maps.resolution));
    files.save_points(map.name, clouds.back());
  }
  if (maps.live) files.save_derived(*maps.live, maps.T_map_robot, maps.also_stood);
  // Last: where the disk is full, the maps come before pictures of them.
  for (const MapsToSave::Landmarks& map : maps.landmarks) files.save_pictures(map);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    const MapsToSave::Dense& map = maps.dense[i];
    if (!map.is_live || !maps.live || !files.save_pictures(map, *maps.live))
      files.save_pictures(map, clouds[i], maps.resolution);
  }
  save_kept(maps, files);
  return files.written();
}

void BackgroundSaver::begin(MapsToSave maps, const std::filesystem::path& folder, std::int64_t revision,
                            const std::string& formats) {
  const auto made = [folder] {
    std::filesystem::create_directories(folder);
    return HeldFolder(folder);
  };
  begin_in(std::move(maps), made, revision, formats);
}

void BackgroundSaver::begin(MapsToSave maps, const HeldFolder& folder, std::int64_t revision,
                            const std::string& formats) {
  begin_in(
      std::move(maps), [folder] { return folder; }, revision, formats);
}

void BackgroundSaver::begin_in(MapsToSave maps, const Folder& folder, std::int64_t revision,
                               const std::string& formats) {
  saving_ = std::async(std::launch::async, [maps = std::move(maps), folder, revision, formats] {
    Outcome outcome{revision, {}, "", {}};
    const auto begin = std::chrono::steady_clock::now();
    try {
      outcome.files = save_maps(maps, folder(), formats);
    } catch (const std::exception& error) {
      outcome.error = error.what();
    }
    outcome.took = std::chrono::steady_clock::now() - begin;
    return outcome;
  });
}

std::optional<BackgroundSaver::Outcome> BackgroundSaver::take_outcome(bool wait) {
  if (!busy()) return std::nullopt;
  if (!wait && saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
  return saving_.get();
}

}  // namespace lcmslam
