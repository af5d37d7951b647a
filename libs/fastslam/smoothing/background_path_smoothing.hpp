#pragma once
// Smoothing of planar landmarks of known identity (PathSmoother) beside the filter: when it is worth it, in a
// thread, and taken over at a message time, so that a replay gives the same bytes.
//
//   add() every step  ->  begin..()  ->  add() ...  ->  due(now)  ->  take_over(): samples of the path as it
//   was at begin(), and the steps since, which the particles drawn from them go once more
//
// The solver's time is bounded by the path's length and not by the clock: it has 0.1 ms a pose of message
// time, and take_over() waits where that is not enough. What is added meanwhile stands aside until then.

#include <future>
#include <optional>
#include <vector>

#include <lcmslam/fastslam/smoothing/path_smoother.hpp>
#include <lcmslam/fastslam/smoothing/step_record.hpp>

namespace lcmslam {

/// The path's posterior as it was when smoothing began, and what happened since.
struct SmoothedPath {
  double cost = 0;                  ///< per measurement, see PathSmoother::solve()
  SensorCalibration sensor;         ///< of all samples
  std::vector<PathSample> samples;  ///< one for each particle, the first the mode; empty: not solved
  CalibrationCovariance calibration_covariance;  ///< given the path
  std::vector<SmoothedPose> path;
  std::vector<StepRecord> since;
  bool requested = false;
};

/// Stays where it is: the thread works on it.
class BackgroundPathSmoothing {
 public:
  explicit BackgroundPathSmoothing(const FastSlamSettings& settings);

  /// All are planar and of known identity.
  static bool fits(const std::vector<FeaturePoint>& points);
  /// The next step; its points fit.
  void add(StepRecord step);

  /// Begins when there is a reason and the solver has rested: it may have settings.rejuvenation_share of a
  /// core, twice that where few lineages are left. `reunion`: a landmark came back after long or was
  /// contradicted.
  void begin_when_due(bool reunion, bool few_lineages);
  /// Somebody asks for the path. False when there is none yet. What runs already will do.
  bool begin_on_request();

  bool requested() const { return running_ && running_->requested; }
  bool running() const { return running_.has_value(); }
  /// The step at `now` shall take the result over.
  bool due(Utime now) const { return running_ && now >= running_->due; }
  /// Waits for what runs.
  SmoothedPath take_over();
  /// The same from the whole path, at once. Nothing may run.
  SmoothedPath smooth();

 private:
  struct Running {
    std::future<SmoothedPath> result;
    Utime due = 0;  // message time
    bool requested = false;
  };
  void begin();
  void add_to_path(const StepRecord& step);
  Utime solving_time() const;

  FastSlamSettings settings_;
  PathSmoother smoother_;          // the solver's while it runs
  Random stream_;                  // the solver's, too
  std::vector<StepRecord> since_;  // steps meanwhile
  Utime now_ = 0;                  // of the newest step
  Utime begun_at_ = 0;
  bool reunited_ = false;           // since then
  std::optional<Running> running_;  // last: it ends before what it works on
};

}  // namespace lcmslam
