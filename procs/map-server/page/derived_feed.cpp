#include "procs/map-server/page/derived_feed.hpp"

#include <spdlog/spdlog.h>

namespace lcmslam {

DerivedFeed::DerivedFeed(Board& board) : layers_(board), thread_([this] { work(); }) {}

DerivedFeed::~DerivedFeed() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void DerivedFeed::show(std::shared_ptr<const LiveMap> map,
                       const std::optional<Eigen::Isometry3d>& T_map_robot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (busy_) return;
  next_ = Look{std::move(map), T_map_robot};
  wake_.notify_all();
}

void DerivedFeed::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stop_ || next_; });
    if (stop_) return;
    const Look look = *std::exchange(next_, std::nullopt);
    busy_ = true;
    lock.unlock();
    try {
      layers_.show(look.map, look.T_map_robot);
    } catch (const std::exception& error) {
      spdlog::error("the page is not shown what is derived: {}", error.what());
    }
    lock.lock();
    busy_ = false;
  }
}

}  // namespace lcmslam
