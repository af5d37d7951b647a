#pragma once
// Gaussian noise added to a path, to see how much of it a filter takes away again (thesis, figure 2.10:
// mean 0, sigma 0.02 m).

#include <optional>

#include <lcmslam/geometry/motion_buffer.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

enum class MotionNoiseMode {
  random_walk,  ///< each draw adds to the offset from the path: the error grows with the root of time
  white         ///< each draw is the offset from the path
};

struct MotionNoiseSettings {
  MotionNoiseMode mode = MotionNoiseMode::random_walk;
  Eigen::Vector3d sigma = {0.02, 0.02, 0};  ///< m, each axis of the odometry frame; z 0: planar robots
  double rate = 10;                         ///< Hz, draws in message time, however many messages come

  void check() const;  ///< throws std::invalid_argument that names the wrong value
};

/// Draws stand on a fixed grid of message time that begins at the first sample; the offset is constant
/// between them. The rotation and everything else stay untouched.
///
/// Covariance: the difference of two samples' covariances must be that of the motion between them
/// (motion_buffer.hpp), along the noisy path. A random walk grows by sigma^2 a draw. White noise has 2
/// sigma^2 between any two draws; as accumulated covariances can but add up, it grows by 2 sigma^2 a draw:
/// right from one draw to the next, too wide over several.
class MotionNoise {
 public:
  MotionNoise(const MotionNoiseSettings& settings, Random random);

  /// A stamp that goes back starts a new path (the random numbers go on).
  MotionSample apply(const MotionSample& sample);

 private:
  void draw(int count);

  MotionNoiseSettings settings_;
  Random random_;
  std::optional<Utime> start_;  // of the grid
  Utime newest_ = 0;
  std::int64_t draws_ = 0;                              // on the grid so far
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();    // m, odometry frame
  Eigen::Vector3d variance_ = Eigen::Vector3d::Zero();  // m^2, since the last sample
  struct Pair {
    MotionSample clean, noisy;
  };
  std::optional<Pair> before_;  // the last sample
};

}  // namespace lcmslam
