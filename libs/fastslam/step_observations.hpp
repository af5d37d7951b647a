#pragma once
// Which of the landmarks that a frame shows the particles are weighed by, and what the best particle then
// believes of them.

#include <vector>

#include <lcmslam/fastslam/association/frame_association.hpp>
#include <lcmslam/fastslam/particle.hpp>
#include <lcmslam/fastslam/step_result.hpp>

namespace lcmslam {

/// A step's old landmarks. Matches are ordered by slot.
struct StepObservations {
  std::vector<LandmarkMatch> observed;    ///< the particles are weighed by these
  std::vector<LandmarkMatch> accepted;    ///< of these, by the best particle
  std::vector<LandmarkMatch> seen;        ///< again, used or not; not what the best particle rejects
  std::vector<VisibleLandmark> expected;  ///< ought to be seen
  std::vector<int> contradicted;          ///< slots of known identity that the best particle rejects
};

/// The most informative matches, and all of known identity. All matches are `seen` until judge() says
/// otherwise.
StepObservations select_observations(const FrameAssociation& association, const FeatureFrame& frame,
                                     const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                     const FastSlamSettings& settings);

/// Makes up for errors of one landmark that are alike from frame to frame (settings.correlation_time), by the
/// time since it was measured last.
void widen_for_correlation(const std::vector<LandmarkMatch>& observed, Utime utime, double correlation_time,
                           LandmarkIndex& index, std::vector<FeaturePoint>& points);

/// What the best particle rejects was not seen: it may become a new landmark (thesis 2.3.2). Completes the
/// observations and reports on each feature. Returns whether it believes a landmark of known identity.
bool judge(const Verdict& verdict, const FrameAssociation& association,
           const std::vector<FeaturePoint>& points, const LandmarkIndex& index,
           StepObservations& observations, StepResult& result);

/// What became of a match.
AssociationReport report(const LandmarkMatch& match, AssociationOutcome outcome,
                         const std::vector<FeaturePoint>& points, const LandmarkIndex& index);

}  // namespace lcmslam
