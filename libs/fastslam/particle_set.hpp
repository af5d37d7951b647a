#pragma once
// FastSLAM's particles: hypotheses of the path, each with its own map, weighed by how well their maps predict
// what is observed. With what they share of the odometry's calibration they are the filter's whole posterior;
// which feature shows which landmark is decided outside.
//
// Each particle has a random stream of its own, so that results do not depend on how many threads compute.

#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <lcmslam/fastslam/association/association.hpp>
#include <lcmslam/fastslam/ground_pull.hpp>
#include <lcmslam/fastslam/odometry_calibration.hpp>
#include <lcmslam/fastslam/particle.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/fastslam/smoothing/path_smoother.hpp>
#include <lcmslam/geometry/random.hpp>

namespace lcmslam {

/// Where a step leads the particles before they look. Without poses: each goes as predict()'s odometry says,
/// by its own calibration, and learns that.
struct StepPrior {
  Matrix6d covariance = Matrix6d::Zero();           ///< right perturbation
  std::optional<Eigen::Isometry3d> T_from_to;       ///< the observations agree on another motion
  std::optional<Eigen::Isometry3d> T_world_robot;   ///< or on a pose: the robot was found again
  std::optional<GroundPull> ground = std::nullopt;  ///< what the plane says of where the odometry leads

  bool corrected() const { return T_from_to || T_world_robot; }
};

class ParticleSet {
 public:
  explicit ParticleSet(const FastSlamSettings& settings);

  /// All six degrees are free from now on.
  void leave_plane(const FastSlamSettings& settings) { settings_ = settings; }

  const std::vector<Particle>& particles() const { return particles_; }
  std::size_t size() const { return particles_.size(); }
  const Particle& best() const { return particles_[static_cast<std::size_t>(best_)]; }
  int best_index() const { return best_; }
  /// Normalised.
  std::vector<double> weights() const;
  /// What all particles share of the odometry's calibration.
  const OdometryCalibration& calibration() const { return calibration_; }

  /// Begins a step; `odometry` as motion_prior() gives it. Returns the motion that the best particle's
  /// calibration makes of it, with its covariance and that of the blind steps before.
  Motion predict(const Motion& odometry);
  /// A blind step: nothing is observed, and nothing is mapped. No observation will ever weigh what would be
  /// drawn now, so all particles go as predicted, and the covariance is kept for the next draw.
  void go_blindly(const StepPrior& prior);
  /// Of the robot's pose, body frame: what the blind steps have added since the particles were drawn last.
  const Matrix6d& undrawn() const { return undrawn_; }
  /// It becomes an error that all particles share. Returns it.
  Matrix6d share_undrawn() { return std::exchange(undrawn_, Matrix6d::Zero()); }
  /// Every particle draws its new pose, weighs it and updates its landmarks. `observed` are of the map, by
  /// index in `points`. Returns the verdict of the particle that is the heaviest now.
  Verdict propose_weigh_update(const StepPrior& prior, const std::vector<LandmarkMatch>& observed,
                               const std::vector<FeaturePoint>& points);
  /// Landmarks are made in all particles alike, where each one sees them.
  void make_landmarks(const std::vector<LandmarkMatch>& created, const std::vector<FeaturePoint>& points);

  /// The particle of highest weight becomes the best. Returns weights().
  std::vector<double> choose_best();
  struct Estimate {
    Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();  ///< that the settings name
    Matrix6d spread = Matrix6d::Zero();  ///< of the particles about it, drawn or not, body frame
  };
  Estimate estimate(const std::vector<double>& weights) const;
  /// Mean square of the particles' poses as seen from their paths' beginnings about `T_world_robot`, body
  /// frame.
  Matrix6d mean_square_from_start(const std::vector<double>& weights,
                                  const Eigen::Isometry3d& T_world_robot) const;

  /// Mean square of a landmark's places as seen from the paths' beginnings about the best particle's; m^2,
  /// world.
  Eigen::Matrix3d mean_square_from_start(int slot) const;

  /// Draws the particles by their weights when the settings want it. Returns whether it did.
  bool resample_when_due(const std::vector<double>& weights);
  /// Resampling has made few ancestors' paths the past of all particles.
  bool coalesced() const;

  /// As many samples as particles; the first, the posterior's mode, becomes the best. `slot_of`: of a
  /// landmark's identity, -1 when it has none.
  void draw_anew(const std::vector<PathSample>& samples, const CalibrationCovariance& calibration_covariance,
                 const std::function<int(std::int32_t)>& slot_of);
  /// The particles were drawn anew, and differ in where their paths began.
  bool start_known() const { return start_known_; }
  /// Where the paths began is no longer kept up.
  void forget_start() { start_known_ = false; }

  /// The world was deformed: landmarks (by slot) stand at `placed` in all particles; those of `carried` and
  /// the robot move by `T_world_correction`.
  void deform(const Eigen::Isometry3d& T_world_correction, const std::map<int, Eigen::Vector3d>& placed,
              const std::vector<int>& carried);

 private:
  template <class Work>
  void for_particles(std::size_t each, const Work& work);
  Eigen::Isometry3d T_world_prior(const Particle& particle, const StepPrior& prior) const;
  void resample(const std::vector<double>& weights);

  FastSlamSettings settings_;
  std::vector<Particle> particles_;
  std::vector<Random> streams_;  // one a particle slot
  Random resampling_stream_;
  OdometryCalibration calibration_;
  Matrix6d undrawn_ = Matrix6d::Zero();
  int best_ = 0;
  bool start_known_ = false;
};

}  // namespace lcmslam
