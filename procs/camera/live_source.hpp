#pragma once
// Cameras, each read by a thread of its own and watched (cameras/watched_camera.hpp).

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include <lcmslam/cameras/image_pairs.hpp>
#include <lcmslam/cameras/watched_camera.hpp>
#include "procs/camera/camera_source.hpp"

namespace lcmslam {

/// One camera of a head.
struct WatchedPart {
  std::string name;  ///< in STATUS: "colour", "depth"; empty: the only one
  OpenCamera open;
  ExpectedImages expected;
};

class LiveSource : public CameraSource {
 public:
  /// One part, or the colour and the depth camera whose images are matched within `tolerance` (us).
  LiveSource(const RgbdCalibration& calibration, std::vector<WatchedPart> parts, Utime tolerance,
             const LiveSettings& settings);
  ~LiveSource() override;

  const RgbdCalibration& calibration() const override { return calibration_; }
  std::optional<CameraEvent> next() override;
  std::size_t frames() const override { return 0; }
  bool is_live() const override { return true; }
  void stop() override;
  SourceHealth health() const override;

 private:
  struct Camera {
    std::string name;
    std::unique_ptr<WatchedCamera> watch;
    std::thread thread;
  };
  void run(std::size_t camera);
  void take(std::size_t camera, CameraShot frame);
  void match(std::size_t camera, CameraShot frame);
  bool is_depth_away() const;
  std::string pair_trouble() const;

  RgbdCalibration calibration_;
  int jpeg_quality_;
  WatchSettings watch_;
  std::vector<Camera> cameras_;

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  ImagePairs pairs_;
  std::deque<CameraShot> ready_;
  std::int64_t skipped_ = 0;                          // shots that nobody took in time
  std::int64_t unpaired_ = 0;                         // images in a row that made no pair
  std::chrono::steady_clock::time_point last_depth_;  // image; at first the start
  bool has_depth_ = false;
  std::int64_t without_depth_ = 0;  // colour images that went out alone
  bool stop_ = false;
};

}  // namespace lcmslam
