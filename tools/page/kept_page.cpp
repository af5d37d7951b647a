#include "tools/page/kept_page.hpp"

#include <fmt/format.h>
#include <algorithm>

#include <lcmslam/live_page/show_on_board.hpp>
#include <lcmslam/live_page/shown_layers.hpp>
#include <lcmslam/live_page/shown_map.hpp>
#include <lcmslam/runtime/version.hpp>
#include "tools/map/rebuilt_layers.hpp"

namespace lcmslam {
namespace {

using nlohmann::json;

ColouredCloud inside(const ColouredCloud& cloud, const Region& region) {
  ColouredCloud part;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!region.contains(cloud.points[i].cast<double>())) continue;
    part.points.push_back(cloud.points[i]);
    part.colours.push_back(cloud.colours[i]);
    if (!cloud.normals.empty()) part.normals.push_back(cloud.normals[i]);
  }
  return part;
}

PageItem sessions_item(const json& sessions) {
  PageItem item{"sessions", ""};
  item.header["sessions"] = sessions;
  return item;
}

}  // namespace

KeptPage::KeptPage(const std::filesystem::path& file, const std::vector<std::string>& wanted, const json& can,
                   Board& board)
    : name_(file.filename().string()), dense_({1'000'000, 1'000'000'000, 1}) {
  MapFile map(file);
  const auto sessions = map.sessions();
  const auto names = names_of(sessions);
  for (const std::string& name : wanted)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw std::runtime_error(fmt::format("{}: there is no session {}; there are {}", file.string(), name,
                                           fmt::join(names, ", ")));
  PageItem about{"about", ""};
  about.header = {{"title", name_}, {"version", lcmslam_version}, {"source", "file"}, {"can", can}};
  show_on(board, std::move(about));

  PlacedSessions dense;
  std::vector<PageEdge> edges;
  std::map<std::string, std::vector<ShownMap::Path>> paths;  // each session its own
  json told = json::array();
  std::int32_t number = 0;
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const StoredSession& session = sessions[i];
    const bool is_frame = map.frame_session(session.mapper) == session.id;
    const bool is_placed = session.T_map_session || is_frame;
    const SessionCounts counts = map.counts(session.id);
    const auto trajectory = map.trajectory(session.id);
    told.push_back({{"name", names[i]},
                    {"mapper", session.mapper},
                    {"begin", trajectory.empty() ? 0 : trajectory.front().utime},
                    {"end", trajectory.empty() ? 0 : trajectory.back().utime},
                    {"current", false},
                    {"joined", session.T_map_session ? json(session.evidence)
                               : is_frame            ? json("")
                                                     : json()},
                    {"keyframes", counts.clouds},
                    {"landmarks", counts.landmarks}});
    const bool is_wanted =
        wanted.empty() ? is_placed : std::find(wanted.begin(), wanted.end(), names[i]) != wanted.end();
    if (!is_wanted || counts.clouds + counts.landmarks == 0) continue;
    const Eigen::Isometry3d T = session.T_map_session.value_or(Eigen::Isometry3d::Identity());
    std::map<std::int32_t, std::int32_t> number_of;
    for (const StoredKeyframe& keyframe : map.keyframes(session.id)) {
      const auto cloud = map.cloud(session.id, keyframe.id);
      if (!cloud) continue;
      number_of[keyframe.id] = number;
      KeyframeTile tile;
      tile.part = {number++, keyframe.utime, T * keyframe.T_map_camera, *cloud, 0};
      dense_.add(tile);
    }
    if (!number_of.empty()) dense[session.id] = T;
    for (const StoredEdge& edge : map.edges(session.id))
      if (number_of.count(edge.from) + number_of.count(edge.to) == 2)
        edges.push_back({number_of[edge.from], number_of[edge.to], edge.kind, edge.error});
    for (Landmark landmark : map.landmarks(session.id)) {
      landmark.mean = T * landmark.mean;
      landmark.covariance = T.linear() * landmark.covariance * T.linear().transpose();
      landmarks_.push_back(landmark);
    }
    ShownMap::Path& path = paths[session.mapper].emplace_back();
    for (const StoredPose& pose : trajectory) path.push_back((T * pose.T_map_robot).translation());
    if (!trajectory.empty() && (session.mapper == "icp" || !T_map_robot_))
      T_map_robot_ = T * trajectory.back().T_map_robot;
  }
  if (dense_.keyframes().empty() && landmarks_.empty())
    throw std::runtime_error(file.string() +
                             ": has nothing to be shown; `lcmslam map info` says what is in it");
  show_on(board, sessions_item(told));

  ShownMap shown(board);
  std::vector<KeyframePose> nodes;
  for (const auto& [id, keyframe] : dense_.keyframes()) nodes.push_back({id, keyframe.T_world_camera});
  shown.graph(nodes, edges);
  shown.clouds(dense_);
  shown.landmarks(landmarks_);
  std::map<std::string, std::vector<const ShownMap::Path*>> lines;
  for (const auto& [mapper, of_sessions] : paths)
    for (const ShownMap::Path& path : of_sessions) lines[mapper].push_back(&path);
  shown.paths(lines);

  no_layers_ = "the file has no keyframes of the dense map";
  if (dense.empty()) return;
  try {
    layers_ = rebuild_layers(map, dense);
  } catch (const StoreError& error) {
    no_layers_ = error.what();
    return;
  }
  ShownLayers(board).show(layers_, T_map_robot_);
}

AskedMap KeptPage::asked_map(const Question& question) const {
  if (!layers_) throw std::runtime_error(no_layers_);
  AskedMap map;
  map.frame = "map";
  map.live = layers_;
  map.T_map_robot = T_map_robot_;
  if (const auto* q = std::get_if<CloudQuestion>(&question.what))
    map.cloud = inside(dense_.merge_all(), q->region);
  if (const auto* q = std::get_if<LandmarksQuestion>(&question.what))
    for (const Landmark& landmark : landmarks_)
      if (q->region.contains(landmark.mean)) map.landmarks.push_back(landmark);
  return map;
}

}  // namespace lcmslam
