#pragma once
// A camera whose messages go wrong: frames of a source, published in real time, some of them disturbed.

#include <chrono>
#include <deque>
#include <memory>
#include <optional>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/runtime/publisher.hpp>
#include "procs/camera/camera_source.hpp"
#include "tools/study/faults/fault.hpp"

namespace lcmslam {

class DisturbedSource {
 public:
  /// `stranger` is another sender on the same bus.
  DisturbedSource(CameraSource& source, Publisher& publisher, Publisher& stranger)
      : source_(source), publisher_(&publisher), stranger_(stranger) {}

  /// Publishes what is due `elapsed` s after the beginning; `active`: the fault that is under way. False at
  /// the end of the source.
  bool publish_until(double elapsed, const Fault* active);
  /// Somebody has started who does not know the calibration; cameras tell it at once.
  void calibrate() { calibrated_ = 0; }
  /// At the moment when a fault begins: what happens once.
  void begin(const Fault& fault);
  /// The camera's process is killed and another one takes its place, as another sender, so many s later. What
  /// is measured until then is lost, wheels too: the simulated camera tells both.
  void restart(Publisher& publisher, double seconds);

  /// Time of the first event, once it is published.
  const std::optional<Utime>& begun() const { return start_; }
  const Eigen::Isometry3d& T_robot_camera() const { return source_.calibration().T_robot_camera; }
  /// T_world_robot of what was published, for the judge alone: it is not sent.
  Trajectory truth() const;

 private:
  void publish(CameraEvent event, const Fault* active);
  void publish_frame(const EncodedFrame& frame, const Fault* active);
  void publish_wheels(Encoders encoders, const Fault* active);
  void publish_calibration(Utime utime);

  CameraSource& source_;
  Publisher* publisher_;
  Publisher& stranger_;
  std::optional<CameraEvent> next_;
  std::optional<Utime> start_;
  Utime newest_ = 0, gone_until_ = 0;  // of what was measured
  Utime calibrated_ = 0;
  std::deque<EncodedFrame> waiting_;  // of a camera that is late
  std::optional<EncodedFrame> first_, last_;
  Utime jump_ = 0;      // of the clock, until now
  double slipped_ = 0;  // rad that each wheel turned for nothing
  Utime wheels_utime_ = 0;
  Trajectory truth_;
};

/// The same frame as a covered camera sees it.
EncodedFrame covered(const EncodedFrame& frame);
/// All of its times moved.
EncodedFrame shifted(EncodedFrame frame, Utime by);

}  // namespace lcmslam
