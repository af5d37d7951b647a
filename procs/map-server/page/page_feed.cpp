#include "procs/map-server/page/page_feed.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cstdlib>

#include <lcmslam/live_page/show_on_board.hpp>
#include <lcmslam/messages/geometry_messages.hpp>

namespace lcmslam {
namespace {

using nlohmann::json;

constexpr double pose_period = 0.08;   // s
constexpr double image_period = 0.1;   // s
constexpr double health_period = 0.5;  // s
constexpr double cloud_period = 0.02;  // s, while more clouds wait than one look may take
// A look's, some 10 ms: commands and a driver's silence wait so long when the first browser comes.
constexpr std::size_t most_points = 40'000;
constexpr double silent_after = 3;             // s without a pose
constexpr Utime longest_unjudged = 1'000'000;  // us between a pose and the last one that truth was known for
constexpr std::size_t most_notices = 30;
constexpr std::size_t most_associations = 10;
constexpr Utime longest_without_tracks = 1'000'000;  // us; then images come without
constexpr std::size_t most_path = 100'000;
constexpr double way_between = 0.01;  // m between two poses of a path that is kept here

/// A path that grows; when it is too long every second pose goes.
void add_to(std::vector<Eigen::Vector3d>& path, const Eigen::Vector3d& point) {
  if (!path.empty() && (point - path.back()).norm() < way_between) return;
  path.push_back(point);
  if (path.size() <= most_path) return;
  for (std::size_t i = 0; 2 * i < path.size(); ++i) path[i] = path[2 * i];
  path.resize((path.size() + 1) / 2);
}

/// A mapper that was started anew calls its map as the one before did.
std::string name_of(const SessionKey& map) {
  return map.frame + " of " + std::to_string(map.sender);
}

}  // namespace

PageFeed::PageFeed(Board& board, const PageSettings& settings)
    : board_(board), map_period_(settings.map_period), map_(board), derived_(board) {}

void PageFeed::connect(Inputs& inputs) {
  inputs.subscribe<odometry_t>("ODOMETRY", 100, [this](const odometry_t& m) { on_odometry(m); });
  inputs.subscribe<ground_truth_t>("GROUND_TRUTH", 1000, [this](const ground_truth_t& m) { on_truth(m); });
  inputs.subscribe<particles_t>("FASTSLAM_PARTICLES", 1,
                                [this](const particles_t& m) { show_on(board_, particles_item(m)); });
  inputs.subscribe<associations_t>("FASTSLAM_ASSOCIATIONS", 5,
                                   [this](const associations_t& m) { on_associations(m); });
  inputs.subscribe<icp_report_t>("ICP_REPORT", 1,
                                 [this](const icp_report_t& m) { show_on(board_, report_item(m)); });
  inputs.subscribe<status_t>("STATUS", 100, [this](const status_t& m) { on_status(m); });
}

void PageFeed::on_associations(const associations_t& message) {
  if (!associations_.empty() && message.utime <= associations_.back().utime) associations_.clear();
  associations_.push_back(message);
  if (associations_.size() > most_associations) associations_.pop_front();
}

void PageFeed::on_odometry(const odometry_t& message) {
  from_message(message.T_odom_robot, "T_odom_robot");
  odometry_ = message;
}

void PageFeed::on_truth(const ground_truth_t& message) {
  const Eigen::Isometry3d T = from_message(message.T_frame_child, "T_frame_child");
  if (message.child_frame != "robot") return;  // of a camera in hand: nobody knows where its robot is
  T_world_robot_ = T;
  truth_ = message.utime;
  truth_error_.truth(message.utime, T);
}

void PageFeed::on_status(const status_t& message) {
  constexpr std::size_t most_processes = 32;
  if (processes_.size() >= most_processes && processes_.count(message.process) == 0) return;
  const auto known = processes_.find(message.process);
  if (known != processes_.end() && known->second.status.sender != message.sender)
    notice(Level::warn, message.process + " began anew");
  processes_[message.process] = {message, now_};
}

void PageFeed::notice(Level level, const std::string& words) {
  const Utime utime = std::chrono::duration_cast<std::chrono::microseconds>(
                          std::chrono::system_clock::now().time_since_epoch())
                          .count();
  notices_.push_front({{"utime", utime}, {"level", to_string(level)}, {"words", words}});
  if (notices_.size() > most_notices) notices_.pop_back();
  PageItem item{"notices", ""};
  item.header["notices"] = notices_;
  show_on(board_, std::move(item));
}

void PageFeed::show(const MapServerNode& maps, double now, bool is_watched) {
  now_ = now;
  const auto due = [&](double& next, double period) {
    if (now < next) return false;
    next = now + period;
    return true;
  };
  const MapServerNode::Shown shown = maps.shown();
  if (!(shown.map == shown_)) begin_map(shown.map, shown.dense != nullptr);
  if (due(next_pose_, pose_period)) show_poses(shown);
  if (!is_watched) return;
  if (due(next_image_, image_period)) show_image(maps);
  if (due(next_health_, health_period)) show_health(shown, now);
  if (!due(next_map_, map_period_)) {
    if (clouds_wait_ && now >= next_clouds_) show_clouds(shown);
    return;
  }
  show_maps(shown);
  show_sessions(maps);
}

void PageFeed::show_sessions(const MapServerNode& maps) {
  PageItem item{"sessions", ""};
  item.header["sessions"] = json::array();
  for (const MapServerNode::ToldSession& session : maps.told_sessions())
    item.header["sessions"].push_back({{"name", session.name},
                                       {"mapper", session.mapper},
                                       {"begin", session.begin},
                                       {"end", session.end},
                                       {"current", session.is_current},
                                       {"kept", session.is_kept},
                                       {"joined", session.joined ? json(*session.joined) : json()},
                                       {"keyframes", session.keyframes},
                                       {"landmarks", session.landmarks}});
  show_on(board_, std::move(item));
}

void PageFeed::stand(double time) {
  for (auto& [who, newest] : newest_) newest.came += time;
  for (auto& [name, heard] : processes_) heard.at += time;
}

/// A pose that stays on the page would look like one of now.
bool PageFeed::is_silent(const std::string& who, Utime utime) {
  Newest& newest = newest_[who];
  if (newest.utime != utime) newest = {utime, now_};
  return now_ - newest.came > silent_after;
}

/// Truth comes late, and not for each pose.
void PageFeed::judge(const std::string& who, const std::string& frame, Utime utime,
                     const Eigen::Isometry3d& T_map_robot) {
  if (const auto distance = truth_error_.error(who, frame, utime, T_map_robot))
    errors_[who] = {utime, *distance};
}

void PageFeed::show_poses(const MapServerNode::Shown& shown) {
  Utime utime = 0;  // of a mapper's newest pose: the wheels may have another clock
  std::map<std::string, Utime> posed;
  std::set<std::string> silent;
  json poses = {{"icp", nullptr}, {"fastslam", nullptr}, {"odometry", nullptr}, {"truth", nullptr}};
  for (const auto& [name, pose] :
       {std::pair("icp", shown.icp_pose), std::pair("fastslam", shown.fastslam_pose)}) {
    if (pose == nullptr) continue;
    utime = std::max(utime, pose->utime);
    posed[name] = pose->utime;
    poses[name] = pose_member(*pose);
    if (is_silent(name, pose->utime)) silent.insert(name);
    const Eigen::Isometry3d T = from_message(pose->T_map_robot, "T_map_robot");
    judge(name, name_of({pose->sender, pose->frame}), pose->utime, T);
    if (odometry_ && !odometry_placed_) {
      T_map_odom_ = T * from_message(odometry_->T_odom_robot, "T_odom_robot").inverse();
      odometry_placed_ = true;
      odometry_path_.clear();  // it was of another place
    }
  }
  if (odometry_) {
    const Eigen::Isometry3d T = T_map_odom_ * from_message(odometry_->T_odom_robot, "T_odom_robot");
    poses["odometry"] = pose_member(*odometry_, T);
    if (silent.size() == posed.size()) utime = odometry_->utime;  // no mapper tells one now
    posed["odometry"] = odometry_->utime;
    if (is_silent("odometry", odometry_->utime)) silent.insert("odometry");
    add_to(odometry_path_, T.translation());
    if (odometry_placed_) judge("odometry", odometry_frame(), odometry_->utime, T);
  }
  if (T_world_robot_) {
    auto T = truth_error_.in_map("icp", *T_world_robot_);
    if (!T) T = truth_error_.in_map("fastslam", *T_world_robot_);
    if (T) {
      poses["truth"] = {{"T", page_pose(*T)}, {"status", "TRUTH"}};
      add_to(truth_path_, T->translation());
      if (is_silent("truth", truth_)) silent.insert("truth");
    }
  }
  if (posed == posed_ && silent == silent_) return;
  posed_ = posed;
  silent_ = silent;
  for (const std::string& who : silent) poses[who]["status"] = "SILENT";
  for (const auto& [name, error] : errors_)
    if (silent.count(name) == 0 && std::abs(newest_[name].utime - error.utime) <= longest_unjudged)
      poses["errors"][name] = rounded_for_page(error.distance);
  poses["utime"] = utime;
  show_on(board_, {"poses", "", std::move(poses), ""});
}

void PageFeed::show_image(const MapServerNode& maps) {
  const auto newest = maps.newest_image();
  if (!newest) return;
  // On a busy machine this process or fastslam leaves out some images, and not the same ones.
  const auto seen = std::find_if(associations_.rbegin(), associations_.rend(),
                                 [&](const associations_t& a) { return maps.image_at(a.utime) != nullptr; });
  const bool is_followed =
      seen != associations_.rend() && newest->colour.utime - seen->utime < longest_without_tracks;
  const auto image = is_followed ? maps.image_at(seen->utime) : newest;
  if (newest->colour.utime < image_) image_ = 0;  // time began anew
  if (image->colour.utime <= image_) return;
  image_ = image->colour.utime;
  if (auto item = image_item(*image, is_followed ? &*seen : nullptr)) show_on(board_, std::move(*item));
}

void PageFeed::show_health(const MapServerNode::Shown& shown, double now) {
  std::vector<ProcessSaid> processes;
  for (const auto& [name, heard] : processes_)
    processes.push_back(process_said(heard.status, now - heard.at));
  std::vector<MapperSaid> mappers;
  for (const auto& [name, pose] :
       {std::pair("icp", shown.icp_pose), std::pair("fastslam", shown.fastslam_pose)})
    if (pose != nullptr)
      mappers.push_back({name, silent_.count(name) > 0 ? "SILENT" : page_status(pose->status), pose->detail});
  show_on(board_, health_.item(processes, mappers, now));
}

void PageFeed::show_clouds(const MapServerNode::Shown& shown) {
  clouds_wait_ = shown.dense != nullptr && !map_.clouds(*shown.dense, most_points);
  next_clouds_ = now_ + cloud_period;
}

void PageFeed::show_maps(const MapServerNode::Shown& shown) {
  show_clouds(shown);
  if (shown.graph != nullptr && shown.dense != nullptr && shown.dense->revision() != graph_shown_) {
    graph_shown_ = shown.dense->revision();
    std::vector<PageEdge> edges;
    std::size_t loops = 0;
    for (const auto& [pair, edge] : shown.graph->edges()) {
      edges.push_back({edge.from_node, edge.to_node, edge.kind, edge.error});
      loops += edge.kind == graph_edge_t::LOOP;
    }
    if (loops > loops_) notice(Level::good, fmt::format("a loop is closed ({} in all)", loops));
    loops_ = loops;
    map_.graph(shown.graph->poses(), edges);
  }
  if (shown.landmarks != nullptr && shown.landmarks->revision() != landmarks_shown_) {
    landmarks_shown_ = shown.landmarks->revision();
    map_.landmarks(shown.landmarks->landmarks());
  }
  map_.paths({{"icp", {shown.icp_path}},
              {"fastslam", {shown.fastslam_path}},
              {"odometry", {&odometry_path_}},
              {"truth", {&truth_path_}}});
  if (!shown.live) return;
  std::optional<Eigen::Isometry3d> T_map_robot;
  if (shown.icp_pose != nullptr) T_map_robot = from_message(shown.icp_pose->T_map_robot, "T_map_robot");
  derived_.show(shown.live, T_map_robot);
}

void PageFeed::begin_map(const SessionKey& map, bool is_dense) {
  next_map_ = 0;  // what it has comes at once
  // The dense map may come after the landmarks, which lie in the same frame.
  const bool joins = is_dense && !is_dense_ && map.frame == shown_.frame;
  is_dense_ = is_dense;
  const std::string before = std::exchange(shown_, map).frame;
  if (joins) return;
  if (!before.empty()) notice(Level::warn, fmt::format("a new map begins: {}", map.frame));
  ++maps_;
  forget_maps();
}

/// Each map has odometry at another place.
std::string PageFeed::odometry_frame() const {
  return std::to_string(maps_) + "/" + odometry_->frame;
}

void PageFeed::forget_maps() {
  map_.forget();
  graph_shown_ = landmarks_shown_ = -1;
  loops_ = 0;
  odometry_placed_ = false;
  odometry_path_.clear();
  truth_path_.clear();
  errors_.clear();
}

}  // namespace lcmslam
