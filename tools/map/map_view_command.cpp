#include <fmt/format.h>
#include <iostream>

#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/rendering/map_picture.hpp>
#include "tools/map/map_commands.hpp"
#include "tools/output_file.hpp"
#include "tools/page/kept_page.hpp"
#include "tools/page/page_host.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

struct ViewOptions {
  std::string file, folder;           // no folder: in a browser
  std::vector<std::string> sessions;  // empty: all
  double resolution = 0.02;           // m
  bool force = false;
};

/// Sessions that lie in one frame: the map's, or that of one whose place nobody knows.
struct Picture {
  std::string name, mapper;
  bool is_map = false;  // its frame is
  ColouredCloud cloud;
  std::vector<Landmark> landmarks;
  std::vector<PicturePath> paths;
};

cv::Vec3b path_colour(std::size_t number) {
  const cv::Vec3b colours[] = {{40, 40, 220}, {200, 120, 20}, {40, 160, 40}, {180, 40, 180}, {20, 150, 220}};
  return colours[number % std::size(colours)];
}

void append(ColouredCloud& all, const ColouredCloud& cloud, const Eigen::Isometry3d& T_map_session) {
  const Eigen::Isometry3f T = T_map_session.cast<float>();
  for (const Eigen::Vector3f& point : cloud.points) all.points.push_back(T * point);
  for (const Eigen::Vector3f& normal : cloud.normals) all.normals.emplace_back(T.linear() * normal);
  all.colours.insert(all.colours.end(), cloud.colours.begin(), cloud.colours.end());
}

class Viewer {
 public:
  explicit Viewer(const ViewOptions& options) : options_(options), map_(options.file) {}

  void run() {
    const auto sessions = map_.sessions();
    const auto names = names_of(sessions);
    for (std::size_t i = 0; i < sessions.size(); ++i)
      if (is_wanted(names[i])) add(sessions[i], names[i]);
    if (pictures_.empty())
      throw std::runtime_error(options_.file +
                               ": has nothing to be drawn; `lcmslam map info` says what is in it");
    fs::create_directories(options_.folder);
    for (const Picture& picture : pictures_) {
      draw(picture, MapView::front, "_front.png");
      draw(picture, MapView::top, "_top.png");
    }
  }

 private:
  bool is_wanted(const std::string& name) const {
    const auto& names = options_.sessions;
    return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
  }

  void add(const StoredSession& session, const std::string& name) {
    const SessionCounts counts = map_.counts(session.id);
    if (counts.clouds + counts.landmarks == 0) return;
    const Eigen::Isometry3d T = session.T_map_session.value_or(Eigen::Isometry3d::Identity());
    const bool is_placed = session.T_map_session || map_.frame_session(session.mapper) == session.id;
    const auto same = std::find_if(pictures_.begin(), pictures_.end(), [&](const Picture& picture) {
      return is_placed && picture.is_map && picture.mapper == session.mapper;
    });
    Picture& picture = same != pictures_.end()
                           ? *same
                           : pictures_.emplace_back(Picture{name, session.mapper, is_placed, {}, {}, {}});
    append(picture.cloud, map_.dense_map(session.id).merge(options_.resolution), T);
    for (Landmark landmark : map_.landmarks(session.id)) {
      landmark.mean = T * landmark.mean;
      picture.landmarks.push_back(landmark);
    }
    PicturePath path{name, path_colour(picture.paths.size()), {}};
    for (const StoredPose& pose : map_.trajectory(session.id))
      path.points.push_back(T * pose.T_map_robot.translation());
    if (!path.points.empty()) picture.paths.push_back(path);
  }

  void draw(const Picture& picture, MapView view, const std::string& ending) {
    PictureRequest request;
    request.view = view;
    request.title = fmt::format("{}: {}", fs::path(options_.file).filename().string(), picture.name);
    if (picture.cloud.size() > 0) request.cloud = &picture.cloud;
    if (!picture.landmarks.empty()) request.landmarks = &picture.landmarks;
    request.paths = picture.paths;
    request.resolution = options_.resolution;
    const fs::path file = fs::path(options_.folder) / (picture.name + ending);
    check_output_file(file, options_.force);
    save_picture(FilePlace(file), draw_map(request));
    std::cout << file.string() << "\n";
  }

  ViewOptions options_;
  MapFile map_;
  std::vector<Picture> pictures_;
};

void show(const ViewOptions& options, const WebSettings& web) {
  Board board;
  const KeptPage page(options.file, options.sessions, {"query"}, board);
  PageDesk desk;
  desk.offer_questions([&](const Question& question) { return page.asked_map(question); });
  host_page(web, board, desk, [] {});
}

}  // namespace

int map_view_command(int argc, char** argv) {
  ViewOptions o;
  WebSettings web;
  CLI::App app{
      "Shows what is in a map file in a browser, as the live page shows a map that grows. With a folder: "
      "pictures of it, NAME_front.png and NAME_top.png. Sessions that were joined are shown together.",
      "lcmslam map view"};
  app.add_option("file", o.file, "an .lcmslam file")->required();
  app.add_option("folder", o.folder, "that takes pictures, made where it is missing; without: in a browser");
  add_page_options(app, web);
  app.add_option("--sessions", o.sessions, "NAMES as `map info` has them, with commas between (all)")
      ->delimiter(',');
  app.add_option("--resolution", o.resolution, "m, of merged clouds (0.02)")->check(CLI::Range(0.001, 1.0));
  app.add_flag("--force", o.force, "overwrite files that exist");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (o.folder.empty())
    show(o, web);
  else
    Viewer(o).run();
  return 0;
}

}  // namespace lcmslam
