#pragma once
// By how much a depth camera errs with the range it measures, told by planes that look bent: no board, no
// truth, while driving.
//
// A time-of-flight camera's distance wiggles by millimetres to and fro (Lindner and Kolb 2006), the same in
// every image. What it shows of a wall that is seen at a slant is then no plane. With w the error, u the unit
// ray and x = r u the measured point, the distance along the ray from the plane through all of them is
//
//   (n . x + d) / n . u = w(r) + (dn . x + dd) / n . u + noise
//
// beside what the plane is uneven by there (planes/bent_plane.hpp). w is piecewise linear in the range. Each
// plane's own normal and distance (dn, dd) are unknown beside it and eliminated, so a plane tells the part of
// w that no other plane could explain; what no plane tells stays at its prior, zero. The prior's deviation is
// the part of the camera's noise that is the same at all ranges (DepthNoise::constant): a camera that is said
// not to err so learns nothing.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include <lcmslam/planes/bent_plane.hpp>
#include <lcmslam/planes/frame_planes.hpp>
#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct RangeErrorSettings {
  bool enabled = true;
  double period = 0.3;
  double length = 0.4;
  double unevenness = 0.005;
  double memory = 300;

  void describe(SettingsVisitor& s) {
    s.flag("enabled", enabled, "learns the depth camera's error by range from planes, and takes it away");
    s.number("period", period, "s", {0, 1000}, "between two images that are learned from, at least");
    s.number("length", length, "m", {0.05, 100}, "of range over which the error hardly changes");
    s.number("unevenness", unevenness, "m", {1e-4, 1},
             "standard deviation of what a surface that looks like a plane rises or falls by along a metre");
    s.number("memory", memory, "", {2, 1e9},
             "images learned from that count: a camera's error changes as it warms");
  }
};

class RangeError {
 public:
  /// Throws std::invalid_argument for a calibration or a setting that is wrong.
  RangeError(const RgbdCalibration& calibration, const RangeErrorSettings& settings);

  /// Learns from a depth image (CV_16UC1 mm of the calibration's size, as it was measured) when one is due.
  void learn(const cv::Mat& depth, Utime utime);
  /// Takes what is known of the error away; where there is nothing (0) there stays nothing.
  void correct(cv::Mat& depth) const;

  /// Measured less true range, m, by the measured one; and its standard deviation.
  double at(double range) const;
  double sigma(double range) const;
  /// m: what a corrected depth errs by, which the calibration states to be `stated` uncorrected.
  double remaining(double stated, double range) const;
  /// The largest at any range, m.
  double largest() const { return known_.mean.cwiseAbs().maxCoeff(); }

 private:
  std::optional<PlaneSample> sample_of(const PlaneFit& fit, const cv::Vec2f& pixel, double z, int cell) const;
  void add_plane(const std::vector<PlaneSample>& samples);
  void solve();

  RangeErrorSettings settings_;
  std::optional<FramePlaneFinder> planes_;  // nothing: it does not learn
  cv::Mat_<cv::Vec2f> rays_;
  cv::Mat_<float> ray_lengths_;
  DepthNoise noise_;
  RangeCurve known_;
  Eigen::MatrixXd prior_, information_;  // of w at the knots: before any plane, from planes
  Eigen::VectorXd told_;
  double learned_ = 0;  // m^2: of the error, in the mean of the ranges of which planes tell
  Utime last_ = 0;
  bool looked_ = false;
};

}  // namespace lcmslam
