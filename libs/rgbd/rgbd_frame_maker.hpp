#pragma once
// Makes the dense mapper's frames: from images whose colour and depth were taken at two times, by two clocks,
// row by row, everything at one moment.
//
//   RgbdFrameMaker maker(settings);
//   maker.calibrate(calibration);
//   auto prepared = maker.prepare(images);              // most of the work; needs no motion
//   ... odometry comes to cover prepared.needed ...
//   const auto made = maker.make(prepared, motion_between, last_utime);
//
// The moment is the colour image's time: depth points are moved there. Where no motion is known, it is
// depth's. A camera that reads its rows one after the other (RgbdCalibration::rolling_shutter) gets them
// straightened to the middle row.

#include <deque>
#include <functional>
#include <optional>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/rgbd/dense_frame.hpp>
#include <lcmslam/rgbd/depth_clock.hpp>
#include <lcmslam/rgbd/depth_view.hpp>

namespace lcmslam {

struct RgbdFrameMakerSettings {
  DepthFilterSettings depth_filter;
  RangeErrorSettings range_error;
  DepthClockSettings depth_clock;
  double cloud_points = 12000;     ///< about as many points a cloud
  double keyframe_points = 12000;  ///< about as many of a coloured cloud, before it is filtered
  double features_within = 0;      ///< s from depth, that features serve where no motion joins both images
  bool intensities = false;        ///< clouds bring colour's; only points that the colour camera sees
};

class RgbdFrameMaker {
 public:
  explicit RgbdFrameMaker(const RgbdFrameMakerSettings& settings);

  /// Before anything is prepared, and when the camera is another one: what was prepared before is void.
  /// Throws std::invalid_argument for a calibration that does not pass check(). What was learned of the
  /// clocks stays, of the depth camera's error by range it does not.
  void calibrate(const RgbdCalibration& calibration);
  bool calibrated() const { return registration_.has_value(); }
  /// Throws std::logic_error before calibrate().
  const RgbdCalibration& calibration() const;

  /// Gives the colour image when it is asked for; empty when it cannot be had.
  using LateColour = std::function<cv::Mat()>;
  struct Prepared {
    RgbdFrame frame;
    LateColour late_colour;
    DepthView view;
    Utime needed = 0;  ///< motion must be known up to this time
  };
  /// `frame` is of the calibration's sizes (check_frame); its depth image is filtered in place and rid of
  /// what is known of its error by range. Where its colour is empty, `late_colour` is asked, once, and only
  /// for a coloured cloud.
  Prepared prepare(RgbdFrame frame, LateColour late_colour = {});

  /// Features of a colour image; the newest few wait for their frame. `make` takes what is there: waiting
  /// would add their latency to the pose's. Who needs them asks whether they have come, or will no more
  /// because later ones have.
  void add(FeatureFrame features);
  void forget_features() { features_.clear(); }  ///< time begins anew
  bool has_features(const Prepared& prepared) const;
  bool awaits_features(const Prepared& prepared) const;
  /// Whether any came in the second before it.
  bool hears_features(const Prepared& prepared) const;

  /// The robot's motion between two times, in any order; nothing where it is not known.
  using MotionBetween = std::function<std::optional<Motion>(Utime from, Utime to)>;
  struct Made {
    /// `motion` is left to whoever knows the frame before. The colouriser is good for as long as `prepared`
    /// is, and until the next calibration.
    DenseFrame frame;
    Utime depth_utime = 0;  ///< of the depth image, on colour's clock by the calibration
    Eigen::Isometry3d T_frame_depth =
        Eigen::Isometry3d::Identity();  ///< robot at frame.utime <- at depth_utime
    /// s, added to depth_utime when the cloud was brought to the colour image's time; nothing where it was
    /// not.
    std::optional<double> added_to_depth;
  };
  /// `previous`: a time some frames ago at most; from there to the colour image the camera's velocity is
  /// taken.
  Made make(Prepared& prepared, const MotionBetween& motion_between, Utime previous) const;

  /// Where a keyframe's features and where the cloud of the frame placed the robot, which turned by `motion`
  /// in `seconds` before: what depth's clock is learned from. `added_to_depth`: as made.
  void observe(const Eigen::Isometry3d& T_world_features, const Eigen::Isometry3d& T_world_cloud,
               const Motion& motion, double seconds, const std::optional<double>& added_to_depth);
  /// What the calibration leaves of the difference between both clocks.
  const DepthClock& depth_clock() const { return depth_clock_; }
  /// What the depth camera errs by, as learned; nothing before calibrate().
  const std::optional<RangeError>& range_error() const { return range_error_; }

 private:
  /// How depth's rows come to the moment.
  struct Way {
    Eigen::Isometry3d T_colour_depth_time = Eigen::Isometry3d::Identity();  // as DepthRegistration's
    bool joined = false;                     // images of different moments, motion known
    Vector6d row_motion = Vector6d::Zero();  // the camera's twist from the first row to the last
  };

  Utime clock_correction() const;
  Vector6d row_motion(const MotionBetween& motion_between, Utime previous, Utime utime) const;
  ColouredCloud colourise(Prepared& prepared, const Way& way) const;
  std::optional<FeatureFrame> features_at(const Prepared& prepared, const Way& way) const;

  RgbdFrameMakerSettings settings_;
  std::optional<DepthRegistration> registration_;
  std::optional<DepthPoints> depth_points_;
  std::optional<DepthFilter> filter_;
  std::optional<RangeError> range_error_;
  DepthClock depth_clock_;
  std::deque<FeatureFrame> features_;  // the newest few
};

}  // namespace lcmslam
