#pragma once
// What the page is shown: what messages say as they come, and of both maps what has changed.

#include <deque>
#include <map>
#include <optional>
#include <set>

#include <lcmslam/ground_truth_t.hpp>
#include <lcmslam/live_page/shown_map.hpp>
#include <lcmslam/live_page/truth_error.hpp>
#include <lcmslam/runtime/inputs.hpp>
#include "procs/map-server/map_server_node.hpp"
#include "procs/map-server/page/derived_feed.hpp"
#include "procs/map-server/page/message_items.hpp"

namespace lcmslam {

class PageFeed {
 public:
  PageFeed(Board& board, const PageSettings& settings);

  /// What the map server itself does not listen to.
  void connect(Inputs& inputs);

  /// Looks at what has changed. `now` s, of a clock that goes on. While nobody watches only poses are
  /// followed: paths and errors count from the begin.
  void show(const MapServerNode& maps, double now, bool is_watched = true);

  /// So much of the time, s, passed for who watches alone: a log that is shown stood still, and nobody was
  /// silent.
  void stand(double time);

  /// For the list of what happened.
  void notice(Level level, const std::string& words);

 private:
  void on_odometry(const odometry_t& message);
  void on_truth(const ground_truth_t& message);
  void on_status(const status_t& message);
  bool is_silent(const std::string& who, Utime utime);
  void judge(const std::string& who, const std::string& frame, Utime utime,
             const Eigen::Isometry3d& T_map_robot);
  void show_poses(const MapServerNode::Shown& shown);
  void on_associations(const associations_t& message);
  void show_image(const MapServerNode& maps);
  void show_maps(const MapServerNode::Shown& shown);
  void show_clouds(const MapServerNode::Shown& shown);
  void show_sessions(const MapServerNode& maps);
  void show_health(const MapServerNode::Shown& shown, double now);
  void begin_map(const SessionKey& map, bool is_dense);
  std::string odometry_frame() const;
  void forget_maps();

  Board& board_;
  double map_period_;  // s
  double now_ = 0, next_pose_ = 0, next_image_ = 0, next_map_ = 0, next_health_ = 0, next_clouds_ = 0;
  SessionKey shown_;  // the map that is shown
  bool is_dense_ = false;
  int maps_ = 0;  // that began

  std::optional<odometry_t> odometry_;
  Eigen::Isometry3d T_map_odom_ = Eigen::Isometry3d::Identity();  // where icp began
  bool odometry_placed_ = false;
  std::map<std::string, Utime> posed_;  // of the poses that were shown last, by who told them
  struct Newest {
    Utime utime = -1;
    double came = 0;  // s
  };
  std::map<std::string, Newest> newest_;  // poses, by who tells them
  std::set<std::string> silent_;          // who tells none any more
  TruthError truth_error_;
  std::optional<Eigen::Isometry3d> T_world_robot_;
  Utime truth_ = -1;  // of that
  struct Error {
    Utime utime;
    double distance;  // m
  };
  std::map<std::string, Error> errors_;  // the last that was known, by whose pose it is of
  std::vector<Eigen::Vector3d> odometry_path_, truth_path_;
  std::deque<associations_t> associations_;  // the newest last: whose images have come is not known before
  Utime image_ = 0;                          // that was shown last

  struct Heard {
    status_t status;
    double at;
  };
  std::map<std::string, Heard> processes_;
  Health health_;

  ShownMap map_;
  bool clouds_wait_ = false;  // beyond what one look takes
  std::int64_t graph_shown_ = -1, landmarks_shown_ = -1;
  std::size_t loops_ = 0;
  std::deque<nlohmann::json> notices_;
  DerivedFeed derived_;
};

}  // namespace lcmslam
