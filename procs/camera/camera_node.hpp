#pragma once
// Publishes what a source gives: a camera's images at once, a recording's at the pace at which they were
// measured, another driver's as they come.

#include <condition_variable>
#include <deque>
#include <mutex>
#include <set>
#include <thread>

#include <lcmslam/images_t.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/camera/camera_source.hpp"
#include "procs/camera/event_pace.hpp"
#include "procs/camera/foreign_images.hpp"

namespace lcmslam {

class CameraNode : public Node {
 public:
  using Settings = CameraSettings;
  static Settings read(const ConfigNode& config) { return read_camera_settings(config); }

  /// Gives what is published.
  using OpenSource = std::unique_ptr<CameraSource> (*)(const Settings& settings);

  CameraNode(const ConfigNode& config, Publisher& publisher, OpenSource open = make_camera_source);
  CameraNode(const Settings& settings, Publisher& publisher, OpenSource open = make_camera_source);
  ~CameraNode() override;

  void connect(Inputs& inputs) override;
  std::optional<Duration> work() override;
  NodeReport report() const override;

 private:
  using Clock = std::chrono::steady_clock;

  void prefetch();
  void warn() const;  // the first time something goes wrong, and at the end
  std::optional<CameraEvent> pop();
  bool consumers_ready();
  Clock::time_point due(const CameraEvent& event, Clock::time_point now);
  void publish(const CameraEvent& event);
  void publish_calibration();
  void on_foreign_images(const images_t& images);
  void relay(const images_t& images);
  void make_room();

  Publisher& publisher_;
  std::unique_ptr<CameraSource> source_;
  std::set<std::string> wait_for_;  // processes that have not reported yet
  Clock::time_point wait_until_;

  // Filled by the prefetching thread, so that rendering and reading never delay the encoders.
  std::deque<CameraEvent> ready_;
  std::size_t ready_frames_ = 0;
  bool source_ended_ = false;
  bool stop_ = false;
  std::string failure_;
  std::size_t malformed_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;

  std::optional<ForeignImages> foreign_;  // where the source relays them
  std::optional<CameraEvent> next_;
  std::optional<Clock::time_point> due_;  // of next_, where it is paced
  EventPace pace_;
  Utime last_utime_ = 0;
  std::string misfit_;              // why another driver's images are not of the calibration; empty: they are
  Clock::time_point calibrated_;    // when its calibration was last told
  bool calibration_asked_ = false;  // by a process that has just started
  std::size_t frames_sent_ = 0;
  std::size_t skipped_ = 0;  // a camera's images that went out of date before their turn
  double slowed_ = 0;        // s by which the source fell behind
};

}  // namespace lcmslam
