#pragma once
// A reference for recordings without truth: all poses and landmarks at once, by least squares over every
// factor. Written apart from the filter and its smoother, with which it shares no code.

#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

struct BatchSolution {
  Trajectory path;
  double cost = 0;            ///< half the sum of squared residuals, each divided by its sigma
  std::size_t residuals = 0;  ///< consistent factors cost half a residual each
  double odometry_rms = 0, landmark_rms = 0;  ///< of the residuals, in sigmas
  bool converged = false;
};

/// `recording`: with odometry as poses and planar offsets (Victoria Park), of known identity; covariances
/// as the recording has them. Each pose starts where dead reckoning leads from the solution so far, which
/// is found anew every 100 poses: from dead reckoning alone the heading is wrong by half a turn at the end,
/// and the solver finds another valley. Throws std::invalid_argument for other recordings.
BatchSolution solve_batch(const LandmarkRecording& recording);

}  // namespace lcmslam
