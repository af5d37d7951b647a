#pragma once
// Where a particle's new pose is drawn from. With prior p(x) = N(T_prior, Q) and proposal q(x) the
// importance weight of a drawn pose is p(z | x) p(x) / q(x); a proposal returns log p(x) - log q(x),
// the caller multiplies by the observations' likelihood. So every proposal is unbiased.

#include <memory>
#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_filter.hpp>
#include <lcmslam/fastslam/landmarks/landmark_lanes.hpp>
#include <lcmslam/fastslam/settings.hpp>
#include <lcmslam/geometry/random.hpp>
#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// A measurement with the landmark that it is taken for, in one particle's map.
struct ObservedLandmark {
  Measurement measurement;
  LandmarkGaussian landmark;
};

struct ProposedPose {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
  double log_weight = 0;  ///< log p(x) - log q(x)
};

/// A step's measurements, which all particles share, with the landmarks in four particles' maps.
struct ObservedLanes {
  std::vector<Measurement> measurements;
  std::vector<LandmarkLanes> landmarks;  ///< one for each measurement

  ObservedLanes() = default;
  /// Four times the same.
  explicit ObservedLanes(const std::vector<ObservedLandmark>& observations);
};

/// Draws for four particles at once. Each has its own prior and its own random numbers; what it draws does
/// not depend on the others.
class Proposal {
 public:
  virtual ~Proposal() = default;
  /// T_world_prior[lane_count]; one random stream and one proposed pose for each of the first `count`.
  virtual void propose(const Eigen::Isometry3d* T_world_prior, const ObservedLanes& observed, Random* streams,
                       int count, ProposedPose* proposed) const = 0;
  /// One particle alone.
  ProposedPose propose(const Eigen::Isometry3d& T_world_prior,
                       const std::vector<ObservedLandmark>& observations, Random& random) const;
};

/// The proposal that the settings name, for a prior covariance Q (right perturbation, positive
/// definite in the free components).
std::unique_ptr<Proposal> make_proposal(const FastSlamSettings& settings, const Matrix6d& prior_covariance);

/// The Gaussian that the 2.0 proposal draws from: pose and covariance, for tests and diagnosis.
struct PoseGaussian {
  Eigen::Isometry3d T_world_robot = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();
};
PoseGaussian measurement_posterior(const FastSlamSettings& settings, const Matrix6d& prior_covariance,
                                   const Eigen::Isometry3d& T_world_prior,
                                   const std::vector<ObservedLandmark>& observations);

}  // namespace lcmslam
