#pragma once
// The thread that shows frames to the derived maps. Where it is behind, frames are left out, keyframes are
// not. Of whole corrections in a row the last counts, so that no more of them wait than keyframes.

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/live_map/live_map.hpp>

namespace lcmslam {

class LayerWorker {
 public:
  /// Without settings.background all is done by who hands it in. Throws std::invalid_argument that names the
  /// setting.
  explicit LayerWorker(const LiveMapSettings& settings);
  ~LayerWorker();
  LayerWorker(const LayerWorker&) = delete;
  LayerWorker& operator=(const LayerWorker&) = delete;

  using Calibration = LiveMap::Calibration;
  using Frame = std::shared_ptr<const EncodedFrame>;
  struct Images {
    Frame frame;
    Calibration calibration;  ///< by which it was taken
  };

  /// An empty map; what waits for the old one is left out.
  void begin_map(const Calibration& calibration);

  // Before begin_map() nothing happens.
  /// Of space alone, or `with_colour` of the surface too.
  void show(Images images, const FramePose& pose, bool with_colour);
  /// It shows what stands in the way now, and no more.
  void glance(Images images, const FramePose& pose);
  /// What was seen before waits for the newest frame, every other time.
  void keep(int keyframe, Images images, const FramePose& pose, LiveMap::When when = LiveMap::When::now);
  void keep(int keyframe, ColouredCloud cloud, const Eigen::Isometry3d& T_map_camera,
            LiveMap::When when = LiveMap::When::now);
  /// As keep() of before, of a map that no graph moves; and where that lies, T_map_camera by keyframe.
  void adopt(int keyframe, Images images, const FramePose& pose);
  void adopt(int keyframe, ColouredCloud cloud, const Eigen::Isometry3d& T_map_camera);
  void move_adopted(std::map<int, Eigen::Isometry3d> T_map_camera);
  void correct(std::map<int, Eigen::Isometry3d> T_map_camera);
  void follow(std::map<int, Eigen::Isometry3d> T_map_camera);
  /// Waits until all is done, at most so long; whoever works without a thread does all.
  void settle(std::chrono::steady_clock::duration longest);

  /// Null before begin_map().
  std::shared_ptr<const LiveMap> map() const;

  struct State {
    std::int64_t shown = 0;      ///< frames that were no keyframes
    std::int64_t kept = 0;       ///< keyframes
    std::int64_t waiting = 0;    ///< keyframes and corrections
    std::int64_t left_out = 0;   ///< because others came, or there was no room
    std::int64_t imageless = 0;  ///< keyframes of which only the cloud was there
    std::int64_t failed = 0;     ///< that could not be read
    std::string error;           ///< of the last of those
  };
  State state() const;

 private:
  using Job = std::function<void(LiveMap&)>;
  enum class Turn { in_order, correction, whole_correction, newest_frame, before };
  static Turn turn_of(LiveMap::When when);
  void hand_in(Job job, Turn turn);
  void put_in_order(Job job, Turn turn);
  Job next_job();
  void work();
  bool has_work() const;
  bool step(std::unique_lock<std::mutex>& lock);
  bool is_due(LiveMap::Haste haste) const;
  void count(std::int64_t State::*what);

  LiveMapSettings settings_;
  mutable std::mutex mutex_;  // guards what follows; not held while a job is done
  std::condition_variable wake_, idle_;
  std::shared_ptr<LiveMap> map_;
  std::deque<Job> jobs_;         // keyframes and corrections
  std::size_t corrections_ = 0;  // that were handed in since the last of its keyframes
  Job newest_;                   // frame
  std::deque<Job> before_;       // keyframes of before
  bool frame_was_last_ = false;
  // The surface may have keyframes to fuse anew; it is time for one of them, or for all as no job comes.
  bool unfinished_ = false, due_ = false, quiet_ = false;
  int jobs_since_ = 0;  // that one was
  bool stop_ = false, busy_ = false;
  State state_;
  std::thread thread_;
};

}  // namespace lcmslam
