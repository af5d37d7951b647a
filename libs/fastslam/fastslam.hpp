#pragma once
// FastSLAM: a particle filter over robot poses in which each particle keeps its own map of SURF
// landmarks, one small Kalman filter a landmark (Montemerlo 2002, 2003; thesis chapter 2).
//
//   FastSlam slam(settings);
//   StepResult r = slam.step(motion since the last frame, features of this frame);
//   r.T_world_robot; slam.landmarks(); slam.take_changes();
//
// The world is the robot's frame at the first step, or at a later one if it was lost before a landmark was
// given out. Same inputs, settings and seed give the same result to the last bit, however many threads
// cv::setNumThreads allows; the order of a frame's features does not matter.
// One deviation of thesis_preset() from the thesis: descriptors stand in one index that all particles share
// (LandmarkIndex), and a particle finds a landmark by its slot there, not in a kd-tree of its own. Landmarks
// are made in all particles alike and keep their descriptors, so every such tree would hold the same ones and
// answer the same; tests/unit/fastslam/thesis_test.cpp shows it against a filter that has the trees.

#include <memory>
#include <set>
#include <utility>
#include <vector>

#include <lcmslam/fastslam/association/frame_association.hpp>
#include <lcmslam/fastslam/landmarks/publication.hpp>
#include <lcmslam/fastslam/motion_model.hpp>
#include <lcmslam/fastslam/particle_set.hpp>
#include <lcmslam/fastslam/pose_covariance.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/fastslam/smoothing/background_map_smoothing.hpp>
#include <lcmslam/fastslam/smoothing/background_path_smoothing.hpp>
#include <lcmslam/fastslam/step_observations.hpp>
#include <lcmslam/fastslam/step_result.hpp>
#include <lcmslam/geometry/local_frame.hpp>

namespace lcmslam {

class FastSlam {
 public:
  /// Throws std::invalid_argument for settings out of range.
  explicit FastSlam(const FastSlamSettings& settings);

  /// `motion`: from the last step's time to this frame's (ignored in the first step). A frame without
  /// usable features moves the particles by the odometry, and one that is lost is none: they stand.
  StepResult step(const Motion& motion, const FeatureFrame& frame);

  const std::vector<Particle>& particles() const { return particles_.particles(); }
  /// Normalised.
  std::vector<double> weights() const { return particles_.weights(); }
  const LandmarkIndex& index() const { return index_; }
  /// Of a range-bearing sensor, as learned so far.
  const SensorCalibration& sensor_calibration() const { return sensor_; }
  /// Of an observation in the newest smoothed path, robust; below 1 where the noise is as stated. 0: none
  /// yet.
  /// In which T_local_robot is told; another filter may go on in it.
  const LocalFrame& local_frame() const { return local_frame_; }
  void go_on_in(const LocalFrame& local_frame) { local_frame_ = local_frame; }
  double smoothing_cost() const { return smoothing_cost_; }
  /// All landmarks of the best particle that were seen often enough, ordered by slot. Their covariances are
  /// of their places as seen from the robot's first pose.
  std::vector<Landmark> landmarks() const;
  /// What changed in landmarks() since the last call.
  MapChanges take_changes();

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
  bool smoothing() const;
  /// The path that the last step took over; empty when it took none.
  std::vector<SmoothedPose> take_smoothed() { return std::exchange(taken_over_, {}); }

 private:
  struct Predicted {
    Motion motion;                     ///< of the best particle
    std::optional<GroundPull> ground;  ///< that is part of it
  };
  double elapsed(Utime utime) const;
  Predicted predict(const Motion& odometry);
  std::optional<Floor> refuses_ground(const FrameAssociation& association) const;
  bool leave_for(Floor floor);
  void publish_estimate(const ParticleSet::Estimate& estimate, const std::vector<double>& weights,
                        const Motion& motion, const Eigen::Isometry3d& T_robot_camera, StepResult& result);
  Landmark published(int slot) const;
  bool nothing_to_find_back(const FrameAssociation& association,
                            const std::vector<FeaturePoint>& points) const;
  StepResult begin_anew(const Motion& motion, const FeatureFrame& frame);
  bool agree(const FrameAssociation& association, const Verdict& verdict, bool located) const;
  TrackStatus status(const FrameAssociation& association, bool agreed, Utime utime) const;
  void follow_wheels(const Motion& motion);
  void note_agreement(Utime utime);
  void look_whether_carried(const FrameAssociation& association, const std::vector<FeaturePoint>& points,
                            Utime utime);
  bool may_map(const FrameAssociation& association) const;
  bool reunion(const StepObservations& observations) const;
  std::vector<std::int32_t> remove_landmarks(const FeatureFrame& frame,
                                             const std::vector<FeaturePoint>& points,
                                             const StepObservations& observations, StepResult& result);
  std::vector<LandmarkMatch> create_landmarks(const FeatureFrame& frame,
                                              const std::vector<FeaturePoint>& points,
                                              const StepObservations& observations, StepResult& result);

  // fastslam_smoothing.cpp
  void smooth_beside(StepRecord step, bool reunion, const StepResult& result);
  bool take_over_when_due(Utime now);
  std::vector<SmoothedPose> take_over(const std::optional<MapSmoothing>& smoothing);
  bool take_over(const SmoothedPath& smoothed);
  void repeat(const StepRecord& step, std::set<int>& unborn);

  FastSlamSettings settings_;
  LandmarkIndex index_;
  GroundContact ground_;  // of a planar robot
  UnknownMotion unknown_;
  ParticleSet particles_;
  FrameAssociator associator_;
  PoseCovariance covariance_;
  LocalFrame local_frame_;
  LandmarkPublication publication_;
  std::unique_ptr<BackgroundMapSmoothing> map_smoothing_;  // of 3-D landmarks
  std::unique_ptr<BackgroundPathSmoothing>
      path_smoothing_;  // while all landmarks are of known identity and planar
  std::vector<SmoothedPose> taken_over_;
  SensorCalibration sensor_;  // as the smoothed path has it
  double smoothing_cost_ = 0;
  bool started_ = false;
  double unplaced_ = 0;  // s, StepResult::unplaced
  Eigen::Isometry3d T_agreed_robot_ =
      Eigen::Isometry3d::Identity();  // by the wheels, since measurements agreed
  bool stands_ = true;                // about there, as far as wheels know
  bool hidden_ = false;     // what is seen stands before what is known: it says nothing of where the robot is
  double adrift_ = 0;       // s, StepResult::adrift
  Utime utime_ = 0;         // of the last step
  Utime agreed_utime_ = 0;  // of the newest step whose measurements agreed with the map
};

}  // namespace lcmslam
