#pragma once
// The sensor heads, the two pinned ones and those of files: calibration, and the depth half of a frame.

#include <memory>
#include <string>

#include <lcmslam/imaging/calibration.hpp>
#include <lcmslam/imaging/rgbd_frame.hpp>
#include <lcmslam/simulation/depth_truth.hpp>
#include <lcmslam/simulation/head_settings.hpp>
#include <lcmslam/simulation/pixel_noise.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/row_poses.hpp>

namespace lcmslam {

/// A depth camera of either kind: what it truly sees, and what it measures of that.
class DepthSource {
 public:
  virtual ~DepthSource() = default;
  virtual cv::Mat see(const RowPoses& poses, int threads) const = 0;
  /// Fills depth and amplitude of a frame.
  virtual void measure(const cv::Mat& seen, const PixelNoise& noise, int threads, RgbdFrame& frame) const = 0;
  void render(const RowPoses& poses, const PixelNoise& noise, int threads, RgbdFrame& frame) const {
    measure(see(poses, threads), noise, threads, frame);
  }
};

struct SensorHead {
  RgbdCalibration calibration;       ///< as its user is told
  RgbdCalibration built;             ///< as this piece is
  Utime clock = 0;                   ///< us by which this piece's stamps are late
  double frame_rate = 10;            ///< Hz
  double exposure = 1.0 / 60;        ///< s, of the colour camera
  double rolling_shutter = 0;        ///< s, of the colour camera
  double depth_rolling_shutter = 0;  ///< s
  CameraFaults faults;               ///< of the head's file
  std::unique_ptr<DepthSource> depth;
  DepthTolerance tolerance;  ///< of the depth camera's noise
};

/// "tof" or "rgbd"; throws std::invalid_argument for another name. Scene and caster must outlive it.
/// `depth_size`: other pixels of the depth camera behind the same lens, with the same noise of a pixel in
/// metres; empty: the pinned size, which alone Simulation uses. `unit`: which piece of the model
/// (head_piece.hpp); 0: as described.
SensorHead make_head(const std::string& name, const Scene& scene, const RayCaster& caster,
                     cv::Size depth_size = {}, std::uint64_t unit = 0);

/// A head as a file describes it.
SensorHead make_head(const HeadSettings& settings, const Scene& scene, const RayCaster& caster,
                     std::uint64_t unit = 0);

}  // namespace lcmslam
