#include <lcmslam/fastslam/step_observations.hpp>

#include <algorithm>
#include <cmath>

namespace lcmslam {
namespace {

void widen(double factor, Measurement& measurement) {
  const int n = measurement.kind == MeasurementKind::point ? 3 : 2;
  measurement.covariance.topLeftCorner(n, n) *= factor;
}

}  // namespace

StepObservations select_observations(const FrameAssociation& association, const FeatureFrame& frame,
                                     const std::vector<FeaturePoint>& points, const ParticleMap& map,
                                     const FastSlamSettings& settings) {
  StepObservations result;
  result.observed = select_informative(association.matches, frame, points, map, settings);
  result.seen = association.matches;
  for (auto* matches : {&result.observed, &result.seen}) {
    matches->insert(matches->end(), association.known.begin(), association.known.end());
    sort_by_slot(*matches);
  }
  return result;
}

// Errors with the correlation exp(-|dt| / tau) in time: n of them, dt apart, say as much as
// n (1 - rho) / (1 + rho) independent ones. So the covariance is widened by (1 + rho) / (1 - rho) =
// coth(dt / (2 tau)), dt since the landmark's last measurement; after a long time by nothing.
void widen_for_correlation(const std::vector<LandmarkMatch>& observed, Utime utime, double correlation_time,
                           LandmarkIndex& index, std::vector<FeaturePoint>& points) {
  if (correlation_time <= 0) return;
  for (const LandmarkMatch& match : observed) {
    LandmarkRecord& record = index.record(match.slot);
    const double elapsed = std::max(1e-3, 1e-6 * static_cast<double>(utime - record.measured));
    FeaturePoint& point = points[static_cast<std::size_t>(match.point)];
    widen(1 / std::tanh(0.5 * elapsed / correlation_time), point.measurement);
    record.measured = utime;
  }
}

AssociationReport report(const LandmarkMatch& match, AssociationOutcome outcome,
                         const std::vector<FeaturePoint>& points, const LandmarkIndex& index) {
  return {points[static_cast<std::size_t>(match.point)].feature, index.record(match.slot).id, outcome};
}

// `seen` and `observed` are ordered by slot; `seen` holds all of `observed`.
bool judge(const Verdict& verdict, const FrameAssociation& association,
           const std::vector<FeaturePoint>& points, const LandmarkIndex& index,
           StepObservations& observations, StepResult& result) {
  bool located = false;
  std::vector<LandmarkMatch> believed;
  std::size_t next = 0;
  for (const LandmarkMatch& match : observations.seen) {
    const bool used = next < observations.observed.size() && observations.observed[next].slot == match.slot;
    const bool accepted = used && verdict.accepted[next++] != 0;
    const AssociationReport reported = report(match,
                                              accepted ? AssociationOutcome::accepted
                                              : used   ? AssociationOutcome::rejected
                                                       : AssociationOutcome::unused,
                                              points, index);
    result.associations.push_back(reported);
    if (used) result.observations.push_back({reported.feature, reported.landmark, accepted});
    const bool known = index.record(match.slot).known_id >= 0;
    located = located || (known && accepted);
    if (accepted) observations.accepted.push_back(match);
    if (!used || accepted)
      believed.push_back(match);
    else if (known)
      observations.contradicted.push_back(match.slot);
  }
  for (const LandmarkMatch& match : association.rejected)
    result.associations.push_back(report(match, AssociationOutcome::rejected, points, index));
  result.rejected =
      static_cast<int>(observations.seen.size() - believed.size() + association.rejected.size());
  observations.seen = std::move(believed);
  result.matched = static_cast<int>(observations.seen.size());
  result.used = verdict.count;
  result.mean_distance2 = verdict.count > 0 ? verdict.distance2 / verdict.count : 0;
  result.slipped = association.slipped;
  result.loop_closed = association.loop_closed;
  return located;
}

}  // namespace lcmslam
