#pragma once
// The whole path and map at once, from the odometry and all observations of landmarks of known identity:
//
//   sum |e_odometry|^2_Q + sum rho(|z - h(pose, landmark, s)|^2_R) + |c|^2_prior + |s|^2_prior
//
// (c: the odometry's calibration, s: the sensor's) solved by Ceres with Cauchy's rho, so that a wrong
// identity does not deform the map. Its Gaussian posterior gives back to the filter what resampling takes
// away: paths that differ from each other all the way (a move step of resample-move filters, Gilks and
// Berzuini 2001). It is the smoothed map on request, too. Planar poses (x, y, heading) and planar landmarks.
//
// Observations and odometry leave the world's place free. It is chosen so that the path fits best to what the
// filter published at each time, by its covariance then: what was published stays as right as it can, and the
// world does not turn under a robot because its first metres are seen in another light.

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/odometry_calibration.hpp>
#include <lcmslam/fastslam/sensor_calibration.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

struct IdentifiedMeasurement {
  std::int32_t landmark_id = -1;
  Measurement measurement;  ///< planar or range_bearing, as the sensor gave it
};

struct SmoothedPose {
  Utime utime = 0;
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
};

/// One draw from the posterior, as a particle keeps it: given its path, landmarks are independent.
struct PathSample {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();  ///< at the newest step
  Eigen::Isometry3d T_world_start = Eigen::Isometry3d::Identity();  ///< at the first
  CalibrationMean calibration = CalibrationMean::Zero();
  std::map<std::int32_t, LandmarkGaussian> landmarks;
};

class PathSmoother {
 public:
  explicit PathSmoother(const FastSlamSettings& settings);
  ~PathSmoother();

  /// A step of the filter. `motion`: as the odometry says it, with the noise that the filter gives it;
  /// `calibration_jacobian`: of its right perturbation by the calibration (6x4). `T_world_robot` and
  /// `covariance` (body frame): the filter's estimate, where the search starts.
  void add(Utime utime, const Motion& motion, const CalibrationJacobian& calibration_jacobian,
           const std::vector<IdentifiedMeasurement>& seen, const Eigen::Isometry3d& T_world_robot,
           const Matrix6d& covariance);

  /// The landmark was no longer there: what was seen of it counts no more.
  void forget(std::int32_t landmark_id);

  /// Poses: of the first step, and of each with an observation.
  std::size_t size() const;

  /// Minimises; the cost per measurement afterwards (0.5 per residual component when consistent), 0 when
  /// nothing could be solved.
  double solve();

  /// After solve().
  std::vector<SmoothedPose> path() const;
  SensorCalibration sensor() const;

  /// After solve(): draws from the Gaussian posterior, the first its mode, moved on to the newest step by its
  /// motion. Empty when there is no solution or it is singular. `calibration_covariance`: given the path, for
  /// all samples. All are of one sensor() calibration: what it may be wrong by is in their T_world_start, as
  /// if the path had begun elsewhere.
  std::vector<PathSample> sample(std::size_t count, Random& random,
                                 CalibrationCovariance& calibration_covariance);

 private:
  struct Graph;
  std::unique_ptr<Graph> graph_;
};

}  // namespace lcmslam
