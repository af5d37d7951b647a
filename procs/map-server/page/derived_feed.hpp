#pragma once
// The thread that shows the page what is derived: surface, grid, planes and objects. It looks once in a
// while, and only while somebody watches; what is derived goes on meanwhile.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <lcmslam/live_page/shown_layers.hpp>

namespace lcmslam {

class DerivedFeed {
 public:
  explicit DerivedFeed(Board& board);
  ~DerivedFeed();
  DerivedFeed(const DerivedFeed&) = delete;
  DerivedFeed& operator=(const DerivedFeed&) = delete;

  /// What has changed of it is shown, unless the one before is still being looked at. Another map takes the
  /// place of the one before. The grid lies around the robot; without a pose there is none.
  void show(std::shared_ptr<const LiveMap> map, const std::optional<Eigen::Isometry3d>& T_map_robot);

 private:
  struct Look {
    std::shared_ptr<const LiveMap> map;
    std::optional<Eigen::Isometry3d> T_map_robot;
  };
  void work();

  ShownLayers layers_;  // of the thread alone

  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  std::optional<Look> next_;
  bool busy_ = false, stop_ = false;
  std::thread thread_;
};

}  // namespace lcmslam
