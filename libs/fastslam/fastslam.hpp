#pragma once
// FastSLAM: a particle filter over robot poses in which each particle keeps its own map of SURF
// landmarks, one small Kalman filter a landmark (Montemerlo 2002, 2003; thesis chapter 2).
//
//   FastSlam slam(settings);
//   StepResult r = slam.step(motion since the last frame, features of this frame);
//   r.T_world_robot; slam.landmarks(); slam.take_changes();
//
// The world is the robot's frame at the first step. Same inputs, settings and seed give the same
// result to the last bit, however many threads cv::setNumThreads allows; the order of a frame's features does
// not matter.
// One deviation of thesis_preset() from the thesis: descriptors stand in one index that all particles share
// (LandmarkIndex), and a particle finds a landmark by its slot there, not in a kd-tree of its own. Landmarks
// are made in all particles alike and keep their descriptors, so every such tree would hold the same ones and
// answer the same; tests/unit/fastslam/test_thesis.cpp shows it against a filter that has the trees.

#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <lcmslam/fastslam/association/frame_association.hpp>
#include <lcmslam/fastslam/landmarks/publication.hpp>
#include <lcmslam/fastslam/odometry_calibration.hpp>
#include <lcmslam/fastslam/proposal.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/fastslam/smoothing/map_smoother.hpp>
#include <lcmslam/fastslam/smoothing/path_smoother.hpp>
#include <lcmslam/fastslam/smoothing/shared_error.hpp>

namespace lcmslam {

enum class TrackStatus {
  initialising,  ///< first landmarks: the pose is the world's origin
  tracking,      ///< observations agree on the pose
  predicting,    ///< too few observations: the pose rests on odometry
  lost,          ///< there are features, but none fit the map for several steps
  relocalised    ///< found back in this step: the pose may have jumped
};

struct ObservationReport {
  int feature = 0;  ///< index in FeatureFrame::features
  std::int64_t landmark = 0;
  bool accepted = false;  ///< by the best particle
};

/// What became of a feature that has a landmark.
enum class AssociationOutcome {
  accepted,  ///< the landmark was seen again, and the best particle learned from it
  unused,    ///< seen again, but settings.maximum_observations others tell more
  rejected,  ///< looks like the landmark, but the agreed pose or the best particle's gate says no
  created    ///< a new landmark; the feature may have been rejected by another before
};

struct AssociationReport {
  int feature = 0;  ///< index in FeatureFrame::features
  std::int64_t landmark = 0;
  AssociationOutcome outcome = AssociationOutcome::accepted;
};

struct StepResult {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();  ///< estimate that the settings name
  Eigen::Isometry3d T_world_best = Eigen::Isometry3d::Identity();  ///< of the best particle: fits landmarks()
  /// Of T_world_robot exp(xi) as the robot's pose seen from its first one; body frame.
  Matrix6d covariance = Matrix6d::Zero();
  Matrix6d spread = Matrix6d::Zero();  ///< of the particles about T_world_robot, body frame
  double effective_sample_size = 0;
  int best = 0;  ///< index of the best particle after this step
  TrackStatus status = TrackStatus::initialising;
  int offered = 0;               ///< features with a usable 3-D point
  int matched = 0;               ///< landmarks seen again
  int used = 0;                  ///< of these, in the filter
  int rejected = 0;              ///< look-alikes that the pose or the best particle rejected
  int created = 0, removed = 0;  ///< landmarks
  bool loop_closed = false;      ///< relocalised where only drift had led it astray: the map bends to fit
  bool slipped = false;          ///< observations contradicted the odometry, and won
  bool resampled = false;
  bool rejuvenated = false;
  bool motion_usable = true;  ///< false: odometry was not finite; the step went on without
  double mean_distance2 = 0;  ///< of accepted observations at the best particle; about 3 when consistent
  std::vector<ObservationReport> observations;  ///< what the particles were weighed by
  std::vector<AssociationReport> associations;  ///< of all features that have a landmark, for display
};

struct Particle {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_world_start = Eigen::Isometry3d::Identity();  ///< its path's first pose
  double log_weight = 0;                                            ///< not normalised
  CalibrationMean calibration = CalibrationMean::Zero();            ///< of the odometry
  int lineage = 0;  ///< its ancestor when all particles were last drawn anew
  ParticleMap map;
};

class FastSlam {
 public:
  /// Throws std::invalid_argument for settings out of range.
  explicit FastSlam(const FastSlamSettings& settings);

  /// `motion`: from the last step's time to this frame's (ignored in the first step). A frame without
  /// usable features moves the particles by odometry.
  StepResult step(const Motion& motion, const FeatureFrame& frame);

  const std::vector<Particle>& particles() const { return particles_; }
  /// Normalised.
  std::vector<double> weights() const;
  const LandmarkIndex& index() const { return index_; }
  /// Of a range-bearing sensor, as learned so far.
  const SensorCalibration& sensor_calibration() const { return sensor_; }
  /// Of a sight in the newest smoothed path, robust; below 1 where the noise is as stated. 0: none yet.
  double smoothing_cost() const { return smoothing_cost_; }
  /// All landmarks of the best particle that were seen often enough, ordered by slot.
  std::vector<Landmark> landmarks() const;
  /// Smooths the whole path; landmarks() is the smoothed map then. Planar landmarks of known identity: the
  /// particles are drawn anew from the path's posterior. 3-D landmarks: all particles take the smoothed
  /// landmarks, and move as their newest keyframe does. Returns the path; empty when there is none yet, when
  /// both kinds were seen or the settings forbid it.
  std::vector<SmoothedPose> smooth();
  /// The same without a stall: the solver runs beside the following steps, and the first step a while of
  /// message time later (3-D landmarks 2 s, planar ones 0.1 ms a pose) takes its result over and waits for it
  /// if it must, so that a replay gives the same bytes. False when there is nothing to smooth or it runs.
  bool begin_smoothing();
  /// What was asked for runs. (The filter also smooths of its own accord.)
  bool smoothing() const {
    return (running_ && running_->wanted) || (running_path_ && running_path_->wanted);
  }
  /// The path that the last step took over; empty when it took none.
  std::vector<SmoothedPose> take_smoothed() { return std::exchange(taken_over_, {}); }
  /// What changed in landmarks() since the last call.
  MapChanges take_changes() { return publication_.take(particles_[best()].map, index_); }

 private:
  /// A step as the path smoother needs it, and the particles when they go the same way once more.
  struct PathStep {
    Utime utime = 0;
    Motion motion;
    std::vector<FeaturePoint> measured, used;  // as the sensor gave them; corrected and widened
    std::vector<LandmarkMatch> observed, created;
    std::vector<std::int32_t> forgotten;  // identities
    Eigen::Isometry3d T_world_robot;      // the estimate, as said then
    Matrix6d covariance;                  // in the world that it stands in
  };
  /// The smoothed path's posterior, and particles drawn from it.
  struct PathDraw {
    double cost = 0;
    std::vector<PathSample> samples;
    Eigen::Matrix3d calibration_covariance;
    Random stream{0};  // as drawing left it
  };

  /// A step's old landmarks. Matches are ordered by slot.
  struct Sightings {
    std::vector<LandmarkMatch> observed;    // the particles were weighed by these
    std::vector<LandmarkMatch> accepted;    // of these, by the best particle
    std::vector<LandmarkMatch> seen;        // again, used or not; not what the best particle rejects
    std::vector<VisibleLandmark> expected;  // ought to be seen
    std::vector<int> contradicted;          // slots of known identity that the best particle rejects
    bool may_create = true;                 // new ones
  };

  /// What one particle made of the step's observations.
  struct Verdict {
    std::vector<char> accepted;  // one for each observation
    int count = 0;
    double distance2 = 0;  // summed over the accepted
  };

  /// For moving four particles at once; one a thread.
  struct Workspace {
    std::unique_ptr<Proposal> proposal;
    ObservedLanes seen;
    std::vector<const CompactLandmark*> stored;
    std::vector<LearnedLanes> learned;
  };

  std::size_t best() const { return static_cast<std::size_t>(best_); }
  Sightings filter(const Motion& motion, const FeatureFrame& frame, std::vector<FeaturePoint>& points,
                   StepResult& result);
  bool judge(const Verdict& verdict, const FrameAssociation& association,
             const std::vector<FeaturePoint>& points, Sightings& sightings, StepResult& result) const;
  template <class Work>
  void for_particles(std::size_t each, const Work& work);
  void move(Particle* particles, Random* streams, int count, const Eigen::Isometry3d* T_world_prior,
            const std::vector<LandmarkMatch>& observed, Workspace& work, Verdict* verdicts) const;
  void learn(Particle& particle, int lane, const std::vector<LandmarkMatch>& observed, const Workspace& work,
             Verdict& verdict) const;
  void widen_for_correlation(const std::vector<LandmarkMatch>& observed, Utime utime,
                             std::vector<FeaturePoint>& points);
  std::vector<Verdict> move_particles(const FrameAssociation& association,
                                      const std::vector<LandmarkMatch>& observed,
                                      const std::vector<FeaturePoint>& points);
  Motion calibrated_prior(const Motion& motion);
  bool remember(PathStep step);
  void add_to_path(const PathStep& step, const Motion& prior);
  void remember_keyframe(const Motion& motion, const FeatureFrame& frame,
                         const std::vector<FeaturePoint>& points, const std::vector<LandmarkMatch>& created,
                         const StepResult& result);
  std::vector<SmoothedPose> take_over(const std::optional<MapSmoothing>& smoothing);
  void begin_map_smoothing();
  void smooth_path_when_due(bool reunion);
  void begin_path_smoothing();
  Utime solving_time() const;
  bool take_over_path();
  void draw_anew(const PathDraw& draw, const std::set<int>& unborn);
  void repeat(const PathStep& step, std::set<int>& unborn);
  bool coalesced() const;
  std::vector<double> choose_best();
  std::vector<LandmarkMatch> create_landmarks(const FeatureFrame& frame,
                                              const std::vector<FeaturePoint>& points,
                                              const std::vector<int>& chosen);
  void make_landmarks(const std::vector<LandmarkMatch>& created, const std::vector<FeaturePoint>& points);
  static Matrix6d scatter(const std::vector<Vector6d>& offsets, const std::vector<double>& weights,
                          const Vector6d& centre);
  void estimate(const std::vector<double>& weights, StepResult& result) const;
  void tell_covariance(const std::vector<double>& weights, StepResult& result) const;
  bool resample_when_due(const std::vector<double>& weights);
  void resample_particles(const std::vector<double>& weights);

  FastSlamSettings settings_;
  double gate2_;  // d^2 at which exp(-d^2/2) equals the gate
  std::vector<Particle> particles_;
  std::vector<Random> streams_;  // one a particle slot: results do not depend on who computes when
  Random resampling_stream_;
  FrameAssociator associator_;
  OdometryCalibration calibration_;
  std::unique_ptr<PathSmoother> smoother_;  // while all landmarks are of known identity and planar
  struct RunningSmoothing {
    std::future<std::optional<MapSmoothing>> result;
    Utime due = 0;        // message time
    bool wanted = false;  // the path was asked for
  };
  std::optional<RunningSmoothing> running_;
  bool loop_open_ = false;  // a loop was closed, and the map is not bent yet
  struct RunningPath {
    std::future<PathDraw> result;
    Utime due = 0;        // message time
    bool wanted = false;  // the path was asked for
  };
  std::optional<RunningPath> running_path_;  // smoother_ is the solver's until it is taken over
  std::vector<PathStep> since_;              // steps meanwhile
  std::vector<SmoothedPose> taken_over_;
  Utime last_utime_ = 0;
  std::unique_ptr<MapSmoother> map_smoother_;  // while all landmarks are 3-D points
  SensorCalibration sensor_;                   // as the smoothed path has it
  double smoothing_cost_ = 0;
  Random smoothing_stream_;
  Utime smoothed_at_ = 0;  // message time when that began
  bool reunited_ = false;  // since then a landmark came back after long or was contradicted
  LandmarkIndex index_;
  SharedError shared_error_;
  Matrix6d unmodelled_ = Matrix6d::Zero();  // of the settings' shared sigmas
  LandmarkPublication publication_;
  int best_ = 0;
  bool started_ = false;
  bool drawn_anew_ = false;  // once: particles differ in where their paths began
};

}  // namespace lcmslam
