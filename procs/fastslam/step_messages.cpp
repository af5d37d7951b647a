#include "procs/fastslam/step_messages.hpp"

#include <algorithm>
#include <iterator>

#include <lcmslam/messages/geometry_messages.hpp>
#include <lcmslam/messages/motion_messages.hpp>
#include <lcmslam/runtime/node_settings.hpp>

namespace lcmslam {
namespace {

std::int8_t wire_status(TrackStatus status) {
  switch (status) {
    case TrackStatus::initialising:
      return pose_estimate_t::INITIALISING;
    case TrackStatus::tracking:
      return pose_estimate_t::TRACKING;
    case TrackStatus::predicting:
      return pose_estimate_t::DEGRADED;
    case TrackStatus::lost:
      return pose_estimate_t::LOST;
    case TrackStatus::relocalised:
      return pose_estimate_t::RELOCALISED;
  }
  return pose_estimate_t::LOST;
}

std::int8_t wire_outcome(AssociationOutcome outcome) {
  switch (outcome) {
    case AssociationOutcome::accepted:
      return association_t::ACCEPTED;
    case AssociationOutcome::unused:
      return association_t::UNUSED;
    case AssociationOutcome::rejected:
      return association_t::REJECTED;
    case AssociationOutcome::created:
      return association_t::CREATED;
  }
  return association_t::REJECTED;
}

}  // namespace

pose_estimate_t pose_message(Utime utime, const StepResult& result) {
  pose_estimate_t pose = make_pose_estimate(utime, result.T_world_robot, result.covariance);
  pose.status = wire_status(result.status);
  // Of the features that look like a landmark, used or not; those that show something new tell nothing.
  const int known = result.matched + result.rejected;
  pose.quality = known > 0 ? static_cast<float>(result.matched) / static_cast<float>(known) : 0.F;
  pose.inliers = result.used;
  pose.detail = result.slipped ? "wheels slipped" : "";
  if (result.floor != Floor::plane) add_detail(pose.detail, "the floor is not flat here");
  return pose;
}

pose_estimate_t local_pose_message(const pose_estimate_t& pose, const StepResult& result,
                                   const std::string& local_frame) {
  const pose_estimate_t part = make_pose_estimate(pose.utime, result.T_local_robot, result.local_covariance);
  pose_estimate_t local = pose;
  local.frame = local_frame;
  local.T_map_robot = part.T_map_robot;
  std::copy(std::begin(part.covariance), std::end(part.covariance), local.covariance);
  return local;
}

pose_estimate_t correction_message(const pose_estimate_t& pose, const StepResult& result,
                                   const std::string& local_frame) {
  const pose_estimate_t part =
      make_pose_estimate(pose.utime, result.T_world_local, result.correction_covariance);
  pose_estimate_t correction = pose;
  correction.child_frame = local_frame;
  correction.T_map_robot = part.T_map_robot;
  std::copy(std::begin(part.covariance), std::end(part.covariance), correction.covariance);
  return correction;
}

particles_t particles_message(Utime utime, const StepResult& result, const FastSlam& slam) {
  particles_t m;
  m.utime = utime;
  m.frame = "map";
  m.effective_sample_size = static_cast<float>(result.effective_sample_size);
  m.best = result.best;
  const std::vector<double> weights = slam.weights();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const rigid_transform_t T = to_message(slam.particles()[i].T_world_robot);
    particle_t p;
    for (int k = 0; k < 3; ++k) p.trans[k] = static_cast<float>(T.trans[k]);
    for (int k = 0; k < 4; ++k) p.quat[k] = static_cast<float>(T.quat[k]);
    p.weight = static_cast<float>(weights[i]);
    m.particles.push_back(p);
  }
  m.total = m.n_particles = static_cast<int32_t>(m.particles.size());
  return m;
}

associations_t associations_message(const FeatureFrame& frame, const StepResult& result) {
  associations_t m{};
  m.utime = frame.utime;
  m.width = frame.width;
  m.height = frame.height;
  for (const AssociationReport& report : result.associations) {
    const Feature& feature = frame.features[static_cast<std::size_t>(report.feature)];
    association_t a;
    a.feature = report.feature;
    a.x = feature.x;
    a.y = feature.y;
    a.landmark = report.landmark;
    a.outcome = wire_outcome(report.outcome);
    m.associations.push_back(a);
  }
  m.n_associations = static_cast<int32_t>(m.associations.size());
  return m;
}

}  // namespace lcmslam
