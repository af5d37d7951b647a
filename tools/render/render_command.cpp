#include <fmt/format.h>
#include <algorithm>
#include <iostream>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/rendering/animation.hpp>
#include <lcmslam/rendering/map_picture.hpp>
#include <lcmslam/rendering/orbit.hpp>
#include "tools/commands.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

struct RenderOptions {
  std::string file, out, view = "front";
  int pictures = 36;
  double seconds = 6;
  std::optional<double> resolution;
  PictureRequest request;
};

bool has_ending(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::optional<int> parse(RenderOptions& o, int argc, char** argv) {
  CLI::App app{
      "Draws a map or any other cloud of points (m, z up). An orbit is an animated PNG, which browsers "
      "play.",
      "lcmslam render"};
  app.add_option("file", o.file, "FILE.ply or FILE.pcd")
      ->required()
      ->check(CLI::ExistingFile)
      ->check(CLI::Validator(
          [](const std::string& name) {
            if (has_ending(name, ".ply") || has_ending(name, ".pcd")) return std::string();
            return name + " must end in .ply or .pcd" +
                   (has_ending(name, ".lcmslam") ? ": lcmslam map view draws map files" : "");
          },
          "FILE.ply|FILE.pcd"));
  app.add_option("out", o.out, "FILE.png")
      ->required()
      ->check(CLI::Validator(
          [](const std::string& name) {
            return has_ending(name, ".png") || has_ending(name, ".apng") ? "" : name + " must end in .png";
          },
          "FILE.png"));
  app.add_option("--view", o.view, "front: into the room, top: from above, orbit: once around (front)")
      ->check(CLI::IsMember({"top", "front", "orbit"}));
  auto* width =
      app.add_option("--width", o.request.width, "pixels (1600; orbit 480)")->check(CLI::Range(64, 8192));
  auto* height =
      app.add_option("--height", o.request.height, "pixels (1200; orbit 360)")->check(CLI::Range(64, 8192));
  app.add_option("--title", o.request.title, "text above the map");
  app.add_flag("--dark", o.request.dark, "dark background");
  app.add_option("--resolution", o.resolution, "m between neighbouring points (measured)")
      ->check(CLI::Range(1e-4, 10.0));
  app.add_option("--pictures", o.pictures, "orbit: how many a turn (36)")->check(CLI::Range(2, 360));
  app.add_option("--seconds", o.seconds, "orbit: for a turn (6)")->check(CLI::Range(0.1, 3600.0));
  if (const auto exit_code = parse_command(app, argc, argv)) return exit_code;
  if (o.view == "orbit" && !may_stay(o.seconds / o.pictures))
    throw std::runtime_error(fmt::format(
        "--seconds {:g} with --pictures {} shows each for {:g} s, and a picture stays for 0.001 to 60 s",
        o.seconds, o.pictures, o.seconds / o.pictures));
  if (o.view == "orbit" && !*width && !*height) {
    o.request.width = 480;
    o.request.height = 360;
  }
  return std::nullopt;
}

/// m, the median distance from a point to the nearest other one.
double spacing(const ColouredCloud& cloud) {
  constexpr std::size_t sample = 500;
  constexpr double otherwise = 0.02;
  const KdTree tree(cloud.points);
  std::vector<double> distances;
  for (std::size_t i = 0; i < cloud.size(); i += cloud.size() / sample + 1) {
    if (!cloud.points[i].allFinite()) continue;
    const auto nearest = tree.nearest_few(cloud.points[i], 2);
    if (nearest.size() == 2 && nearest[1].squared_distance > 0)
      distances.push_back(std::sqrt(static_cast<double>(nearest[1].squared_distance)));
  }
  if (distances.empty()) return otherwise;
  const auto median = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), median, distances.end());
  return std::clamp(*median, 1e-3, 1.0);
}

/// Clouds without colours come black; grey shows their shape.
void make_visible(ColouredCloud& cloud) {
  const cv::Vec3b black(0, 0, 0), grey(170, 170, 170);
  if (std::all_of(cloud.colours.begin(), cloud.colours.end(), [&](const cv::Vec3b& c) { return c == black; }))
    std::fill(cloud.colours.begin(), cloud.colours.end(), grey);
}

void save_orbit(const RenderOptions& o) {
  std::vector<cv::Mat> pictures;
  PictureRequest request = o.request;
  request.view = MapView::front;
  for (const Eigen::Isometry3d& T_world_viewer : orbit(request, o.pictures)) {
    request.T_world_viewer = T_world_viewer;
    pictures.push_back(draw_map(request));
  }
  save_animation(FilePlace(o.out), pictures, o.seconds / o.pictures);
}

}  // namespace

int render_command(int argc, char** argv) {
  RenderOptions o;
  if (const auto exit_code = parse(o, argc, argv)) return *exit_code;
  ColouredCloud cloud = has_ending(o.file, ".ply") ? load_ply(o.file) : load_pcd(o.file);
  if (cloud.size() == 0) throw std::runtime_error(o.file + ": has no points");
  make_visible(cloud);
  o.request.cloud = &cloud;
  o.request.resolution = o.resolution ? *o.resolution : spacing(cloud);
  if (o.view == "orbit") {
    save_orbit(o);
  } else {
    o.request.view = o.view == "top" ? MapView::top : MapView::front;
    save_picture(FilePlace(o.out), draw_map(o.request));
  }
  std::cout << o.out << ": " << cloud.size() << " points of " << o.file << ", " << o.view << "\n";
  return 0;
}

}  // namespace lcmslam
