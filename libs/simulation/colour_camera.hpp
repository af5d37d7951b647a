#pragma once
// The simulated colour camera: lens distortion, motion blur, exposure and pixel noise.

#include <opencv2/core.hpp>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/imaging/camera_model.hpp>
#include <lcmslam/simulation/pixel_noise.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/row_poses.hpp>

namespace lcmslam {

struct ColourSensor {
  double exposure = 1.0 / 60;   ///< s
  double gain_sigma = 0.01;     ///< relative, of a whole image's brightness
  double read_sigma = 1.2;      ///< grey values
  double shot_variance = 0.02;  ///< grey values squared per grey value
};

class ColourCamera {
 public:
  ColourCamera(const Scene& scene, const RayCaster& caster, const CameraModel& camera,
               const ColourSensor& sensor = {});

  /// CV_8UC3 BGR. `poses` in the middle of the exposure, with the velocity that blurs. `gain`: of the
  /// image's brightness.
  cv::Mat render(const RowPoses& poses, const PixelNoise& noise, int threads, float gain = 1) const {
    return expose(see(poses, threads), poses.velocity, noise, threads, gain);
  }
  /// Without exposure, blur and noise, CV_32FC(5): light, reflected blue, green and red, and the depth along
  /// the optical axis.
  cv::Mat see(const RowPoses& poses, int threads) const;
  /// What the sensor makes of that.
  cv::Mat expose(const cv::Mat& seen, const Vector6d& velocity, const PixelNoise& noise, int threads,
                 float gain) const;

  /// Mean grey value (0..255, more where it would be overexposed) of what the camera sees with gain 1.
  double brightness(const Eigen::Isometry3d& T_world_camera) const;

 private:
  struct Seen {
    float light;
    float colour[3];
    float depth;  // along the optical axis
  };
  Seen see(const RayPacket& rays, int i, const Eigen::Vector3f& origin) const;
  void trace_row(int row, const Eigen::Isometry3f& T_world_camera, cv::Mat& seen) const;
  void expose_row(int row, const cv::Mat& seen, float gain, cv::Mat& sharp) const;
  void blur_row(int row, const Vector6d& velocity, const cv::Mat& sharp, const cv::Mat& seen,
                cv::Mat& image) const;
  void noise_row(int row, const PixelNoise& noise, cv::Mat& image) const;

  const Scene& scene_;
  const RayCaster& caster_;
  CameraModel camera_;
  ColourSensor sensor_;
  cv::Mat rays_;                  ///< CV_32FC2, x/z and y/z
  std::array<float, 256> sigma_;  ///< noise by grey value
};

}  // namespace lcmslam
