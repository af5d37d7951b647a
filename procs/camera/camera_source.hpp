#pragma once
// Where the camera process gets its data: the simulation, a data set, a log, a camera; or the calibration of
// another driver's images alone.

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/odometry/encoders.hpp>
#include "procs/camera/camera_settings.hpp"

namespace lcmslam {

/// True pose, for evaluation only.
struct GroundTruth {
  Utime utime = 0;
  std::string child_frame;  ///< "robot" or "camera": whose pose it is
  Eigen::Isometry3d T_world_child = Eigen::Isometry3d::Identity();
};

using CameraEvent = std::variant<EncodedFrame, Encoders, GroundTruth>;

Utime event_utime(const CameraEvent& event);

/// How a camera is, for STATUS.
struct SourceHealth {
  bool silent = false;  ///< gives no images at present
  std::string trouble;  ///< in words; empty: none
  std::vector<std::pair<std::string, double>> values;
};

class CameraSource {
 public:
  virtual ~CameraSource() = default;
  virtual const RgbdCalibration& calibration() const = 0;
  /// Next event in the order of utime; nothing at the end. Rendering and reading files happen here.
  virtual std::optional<CameraEvent> next() = 0;
  /// Frames in all, 0 when not known.
  virtual std::size_t frames() const = 0;
  /// What the user should know: assumptions made, frames skipped so far.
  virtual std::vector<std::string> notes() const { return {}; }
  /// Frames that could not be read so far.
  virtual std::size_t malformed() const { return 0; }
  /// What went wrong so far, a line for each kind with its count.
  virtual std::vector<std::string> warnings() const { return {}; }
  /// Another driver publishes the images, this source only their calibration: it has no events and no end.
  virtual bool calibrates_only() const { return false; }
  /// The channel of another driver's images, which become CAMERA; empty: none.
  virtual std::string relays() const { return ""; }
  /// A camera: its events are of now, and what is not taken in time is out of date. next() waits for them.
  virtual bool is_live() const { return false; }
  /// Makes next() give nothing from now on. Any thread may call it, and health().
  virtual void stop() {}
  virtual SourceHealth health() const { return {}; }
};

/// As `source` says; cameras are opened by drivers/device_source.hpp. Throws std::runtime_error.
std::unique_ptr<CameraSource> make_camera_source(const CameraSettings& settings);

/// Live, or cached: rendered once into a log below out/cache, then played from there.
std::unique_ptr<CameraSource> make_simulation_source(const SimulationSourceSettings& settings);
/// Always rendered anew.
std::unique_ptr<CameraSource> make_live_simulation(const SimulationSourceSettings& settings);
std::unique_ptr<CameraSource> make_dataset_source(const DatasetSourceSettings& settings);
std::unique_ptr<CameraSource> make_calibration_source(const CalibrationSourceSettings& settings);
std::unique_ptr<CameraSource> make_channel_source(const ChannelSourceSettings& settings,
                                                  const LiveSettings& live);

}  // namespace lcmslam
