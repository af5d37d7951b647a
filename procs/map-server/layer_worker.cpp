#include "procs/map-server/layer_worker.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <lcmslam/messages/camera_messages.hpp>

namespace lcmslam {
namespace {

constexpr std::chrono::milliseconds quiet_time{500};  // without a job: there is time for all that is left

/// Colour costs more than depth, and space does not ask for it.
RgbdFrame decoded(const LayerWorker::Images& images, bool with_colour) {
  EncodedFrame frame = *images.frame;
  if (!with_colour) frame.colour = {};
  return decode_images(frame, *images.calibration);
}

}  // namespace

LayerWorker::LayerWorker(const LiveMapSettings& settings) : settings_(settings) {
  if (settings_.background) thread_ = std::thread([this] { work(); });
}

LayerWorker::~LayerWorker() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void LayerWorker::begin_map(const Calibration& calibration) {
  auto map = std::make_shared<LiveMap>(calibration, settings_);
  const std::lock_guard<std::mutex> lock(mutex_);
  state_.left_out += static_cast<std::int64_t>(jobs_.size() + before_.size()) + (newest_ ? 1 : 0);
  map_ = std::move(map);
  jobs_.clear();
  before_.clear();
  newest_ = {};
  unfinished_ = due_ = false;
}

void LayerWorker::show(Images images, const FramePose& pose, bool with_colour) {
  hand_in(
      [this, images = std::move(images), pose, with_colour](LiveMap& map) {
        RgbdFrame frame = decoded(images, with_colour);
        map.look_through(images.calibration);
        with_colour ? map.add(std::move(frame), pose) : map.show(std::move(frame), pose);
        count(&State::shown);
      },
      Turn::newest_frame);
}

void LayerWorker::glance(Images images, const FramePose& pose) {
  hand_in(
      [this, images = std::move(images), pose](LiveMap& map) {
        RgbdFrame frame = decoded(images, false);
        map.look_through(images.calibration);
        map.glance(std::move(frame), pose);
        count(&State::shown);
      },
      Turn::newest_frame);
}

void LayerWorker::keep(int keyframe, Images images, const FramePose& pose, LiveMap::When when) {
  hand_in(
      [this, keyframe, images = std::move(images), pose, when](LiveMap& map) {
        if (map.has(keyframe)) return;
        RgbdFrame frame = decoded(images, true);
        map.look_through(images.calibration);
        map.keep(keyframe, std::move(frame), pose, when);
        count(&State::kept);
      },
      turn_of(when));
}

void LayerWorker::keep(int keyframe, ColouredCloud cloud, const Eigen::Isometry3d& T_map_camera,
                       LiveMap::When when) {
  hand_in(
      [this, keyframe, cloud = std::move(cloud), T_map_camera, when](LiveMap& map) {
        if (map.has(keyframe)) return;
        map.keep(keyframe, cloud, T_map_camera, when);
        count(&State::imageless);
      },
      turn_of(when));
}

void LayerWorker::adopt(int keyframe, Images images, const FramePose& pose) {
  hand_in(
      [this, keyframe, images = std::move(images), pose](LiveMap& map) {
        if (map.has(keyframe)) return;
        RgbdFrame frame = decoded(images, true);
        map.look_through(images.calibration);
        map.adopt(keyframe, std::move(frame), pose);
        count(map.has(keyframe) ? &State::kept : &State::left_out);
      },
      Turn::before);
}

void LayerWorker::adopt(int keyframe, ColouredCloud cloud, const Eigen::Isometry3d& T_map_camera) {
  hand_in(
      [this, keyframe, cloud = std::move(cloud), T_map_camera](LiveMap& map) {
        if (map.has(keyframe)) return;
        map.adopt(keyframe, cloud, T_map_camera);
        count(map.has(keyframe) ? &State::imageless : &State::left_out);
      },
      Turn::before);
}

void LayerWorker::move_adopted(std::map<int, Eigen::Isometry3d> T_map_camera) {
  hand_in([poses = std::move(T_map_camera)](LiveMap& map) { map.correct(poses); }, Turn::before);
}

void LayerWorker::correct(std::map<int, Eigen::Isometry3d> T_map_camera) {
  hand_in([poses = std::move(T_map_camera)](LiveMap& map) { map.correct(poses); }, Turn::correction);
}

void LayerWorker::follow(std::map<int, Eigen::Isometry3d> T_map_camera) {
  hand_in([poses = std::move(T_map_camera)](LiveMap& map) { map.follow(poses); }, Turn::whole_correction);
}

LayerWorker::Turn LayerWorker::turn_of(LiveMap::When when) {
  return when == LiveMap::When::now ? Turn::in_order : Turn::before;
}

void LayerWorker::hand_in(Job job, Turn turn) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (!map_) return;
  quiet_ = false;
  if (turn == Turn::newest_frame) {
    if (newest_) ++state_.left_out;
    newest_ = std::move(job);
  } else if (turn == Turn::before) {
    before_.push_back(std::move(job));
  } else {
    put_in_order(std::move(job), turn);
  }
  if (thread_.joinable()) return wake_.notify_one();
  while (step(lock)) {
  }
}

void LayerWorker::put_in_order(Job job, Turn turn) {
  // What it corrects must be there: it does not overtake.
  if (!before_.empty()) corrections_ = 0;
  std::move(before_.begin(), before_.end(), std::back_inserter(jobs_));
  before_.clear();
  if (turn == Turn::whole_correction) {
    const std::size_t overtaken = std::min(corrections_, jobs_.size());
    jobs_.erase(jobs_.end() - static_cast<std::ptrdiff_t>(overtaken), jobs_.end());
    state_.left_out += static_cast<std::int64_t>(overtaken);
    corrections_ = 0;
  }
  jobs_.push_back(std::move(job));
  corrections_ = turn == Turn::in_order ? 0 : corrections_ + 1;
}

void LayerWorker::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop_) {
    const auto called = [&] { return stop_ || has_work(); };
    if (!unfinished_) {
      wake_.wait(lock, called);
    } else if (!wake_.wait_for(lock, quiet_time, called)) {
      quiet_ = due_ = true;
    }
    while (!stop_ && step(lock)) {
    }
    idle_.notify_all();
  }
}

bool LayerWorker::has_work() const {
  return !jobs_.empty() || newest_ || !before_.empty() || due_;
}

/// What must be done in order, then the newest frame and what was seen before by turns.
LayerWorker::Job LayerWorker::next_job() {
  const auto take_first = [](std::deque<Job>& jobs) {
    Job job = std::move(jobs.front());
    jobs.pop_front();
    return job;
  };
  if (!jobs_.empty()) return take_first(jobs_);
  frame_was_last_ = newest_ && !(frame_was_last_ && !before_.empty());
  if (frame_was_last_) return std::exchange(newest_, {});
  return before_.empty() ? Job() : take_first(before_);
}

/// One thing that is to be done, without the lock; false: there is nothing.
bool LayerWorker::step(std::unique_lock<std::mutex>& lock) {
  if (!has_work()) return false;
  const Job job = next_job();
  const std::shared_ptr<LiveMap> map = map_;
  bool unfinished = true;  // a frame or a correction may leave something to do
  std::string error;
  const bool quiet = quiet_, surface_is_due = is_due(map->haste());
  busy_ = true;
  lock.unlock();
  try {
    if (job) {
      job(*map);
    } else {
      const bool is_behind = quiet && map->catch_up();
      unfinished = (surface_is_due ? map->improve() : true) || is_behind;
    }
  } catch (const std::exception& e) {
    error = e.what();
  }
  lock.lock();
  busy_ = false;
  if (map == map_) unfinished_ = unfinished;
  // While frames come, several corrections of the graph cost one fusion.
  jobs_since_ = job ? jobs_since_ + 1 : 0;
  due_ = unfinished_ && is_due(map->haste());
  if (error.empty()) return true;
  ++state_.failed;
  state_.error = error;
  return true;
}

/// Whether the surface is to follow the graph now.
bool LayerWorker::is_due(LiveMap::Haste haste) const {
  if (haste == LiveMap::Haste::none) return false;
  return haste == LiveMap::Haste::much || quiet_ || jobs_since_ >= settings_.refit_every;
}

void LayerWorker::settle(std::chrono::steady_clock::duration longest) {
  std::unique_lock<std::mutex> lock(mutex_);
  const bool idle =
      !thread_.joinable() || idle_.wait_for(lock, longest, [&] { return !has_work() && !busy_; });
  const std::shared_ptr<LiveMap> map = map_;
  lock.unlock();
  if (idle && map) map->settle();
}

void LayerWorker::count(std::int64_t State::*what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++(state_.*what);
}

std::shared_ptr<const LiveMap> LayerWorker::map() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return map_;
}

LayerWorker::State LayerWorker::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  State state = state_;
  state.waiting = static_cast<std::int64_t>(jobs_.size() + before_.size());
  return state;
}

}  // namespace lcmslam
