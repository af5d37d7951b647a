#include "procs/map-server/map_files.hpp"

#include <sstream>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/rendering/map_picture.hpp>

namespace lcmslam {
namespace {

const cv::Vec3b path_colour(40, 40, 220);  // BGR

PictureRequest request(MapView view, const std::string& title, const std::vector<Eigen::Vector3d>& path) {
  PictureRequest r;
  r.view = view;
  r.title = title;
  if (!path.empty()) r.paths.push_back({"robot", path_colour, path});
  return r;
}

}  // namespace

MapFiles::MapFiles(std::filesystem::path folder, const std::string& formats) : folder_(std::move(folder)) {
  const std::set<std::string> known = {"ply", "pcd", "png"};
  std::istringstream text(formats);
  for (std::string format; std::getline(text, format, ',');) {
    if (known.count(format) == 0)
      throw std::runtime_error("format '" + format + "' is none of ply, pcd, png");
    formats_.insert(format);
  }
  if (formats_.empty()) formats_ = known;
}

std::filesystem::path MapFiles::file(const std::string& name) {
  written_.push_back((folder_ / name).string());
  return folder_ / name;
}

template <class Map>
void MapFiles::save_points(const std::string& name, const Map& map) {
  if (wants("ply")) save_ply(file(name + "_map.ply"), map);
  if (wants("pcd")) save_pcd(file(name + "_map.pcd"), map);
}

void MapFiles::save_landmarks(const std::string& name, const std::vector<Landmark>& landmarks,
                              const std::vector<Eigen::Vector3d>& path) {
  save_points(name, landmarks);
  if (!wants("png")) return;
  for (const auto& [view, suffix] :
       {std::pair(MapView::front, "_front.png"), std::pair(MapView::top, "_top.png")}) {
    PictureRequest r = request(view, "FastSLAM: " + std::to_string(landmarks.size()) + " landmarks", path);
    r.landmarks = &landmarks;
    save_picture(file(name + suffix), draw_map(r));
  }
}

void MapFiles::save_cloud(const std::string& name, const ColouredCloud& cloud, double resolution,
                          const std::vector<Eigen::Vector3d>& path) {
  save_points(name, cloud);
  if (!wants("png")) return;
  for (const auto& [view, suffix] :
       {std::pair(MapView::front, "_front.png"), std::pair(MapView::top, "_top.png")}) {
    PictureRequest r = request(view, "6-D SLAM: " + std::to_string(cloud.size()) + " points", path);
    r.cloud = &cloud;
    r.resolution = resolution;
    save_picture(file(name + suffix), draw_map(r));
  }
}

}  // namespace lcmslam
