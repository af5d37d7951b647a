#pragma once
// Smoothing of 3-D landmarks (MapSmoother) beside the filter: on request, or after a closed loop, in a thread
// that works on a copy, and taken over at a message time, so that a replay gives the same bytes.
//
//   add() every step  ->  begin..()  ->  add() ...  ->  take_over_when_due(now): the keyframes and landmarks
//   as they were at begin(), smoothed, and how the newest keyframe moved by it
//
// (Planar landmarks have the BackgroundPathSmoothing, which gives more: particles anew. That needs the steps
// since once more; here it is enough that what is newer moves as the newest keyframe does.)

#include <future>
#include <optional>
#include <vector>

#include <lcmslam/fastslam/association/association.hpp>
#include <lcmslam/fastslam/smoothing/map_smoother.hpp>
#include <lcmslam/fastslam/step_result.hpp>

namespace lcmslam {

class BackgroundMapSmoothing {
 public:
  explicit BackgroundMapSmoothing(const FastSlamSettings& settings);

  /// The next step: `result` says what the best particle accepted of `points` and which became landmarks.
  /// `odometry` as the best particle believes it, calibrated. Where anything but points and bearings was
  /// measured, smoothing ends for good; what runs is still taken over.
  void add(Utime utime, const Motion& odometry, const std::vector<FeaturePoint>& points,
           const StepResult& result);

  /// The keyframes have six degrees of freedom from now on.
  void leave_plane(const FastSlamSettings& settings) {
    if (smoother_) smoother_->leave_plane(settings);
  }

  /// Nothing but 3-D landmarks so far.
  bool active() const { return smoother_.has_value(); }
  /// Somebody asks for the path. False when there is none yet. What runs already will do.
  bool begin_on_request();

  bool requested() const { return running_ && running_->requested; }

  struct Result {
    std::optional<MapSmoothing> smoothing;
    bool requested = false;
  };
  /// The step at `now` takes the result over, if it is time, and waits for it if it must.
  std::optional<Result> take_over_when_due(Utime now);
  /// From the whole path, at once; what runs is dropped.
  std::optional<MapSmoothing> smooth();
  /// The filter's map is the smoothed one.
  void taken_over(const MapSmoothing& smoothed) {
    if (smoother_) smoother_->take_over(smoothed);
  }

 private:
  struct Running {
    std::future<std::optional<MapSmoothing>> result;
    Utime due = 0;  // message time
    bool requested = false;
  };
  void begin();
  bool add_keyframe(Utime utime, const Motion& odometry, const std::vector<FeaturePoint>& points,
                    const StepResult& result);

  std::optional<MapSmoother> smoother_;
  bool deform_closed_loops_;
  bool loop_open_ = false;  // a loop was closed, and the map is not deformed yet
  Utime now_ = 0;           // of the newest step
  std::optional<Running> running_;
};

}  // namespace lcmslam
