#include <lcmslam/dense_mapper/icp_mapper.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/start_hypotheses.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

double inlier_share(const RegistrationResult& r) {
  return r.pairs > 0 ? static_cast<double>(r.inliers) / r.pairs : 0;
}

/// Closed-form estimators know no prior: for them odometry is only the start.
const Prior* prior_for(const RegistrationSettings& settings, const Prior& prior) {
  return is_iterative(settings.solver) ? &prior : nullptr;
}

/// What both passes together ask of a target.
RegistrationSettings asked_of_target(const IcpMapperSettings& settings) {
  RegistrationSettings s = settings.fine;
  s.boundary = s.boundary || settings.coarse.boundary;
  s.colour_scale = std::max(s.colour_scale, settings.coarse.colour_scale);
  return s;
}

}  // namespace

RegistrationSettings IcpMapperSettings::coarse_defaults() {
  RegistrationSettings s;
  s.selection = SelectionKind::uniform;
  s.selected_points = 400;
  s.max_distance = 0.25;
  s.min_distance = 0.12;
  s.max_normal_angle = 0.8;
  s.max_iterations = 8;
  s.epsilon_translation = 4e-3;
  s.epsilon_rotation = 2e-3;
  return s;
}

RegistrationSettings IcpMapperSettings::fine_defaults() {
  RegistrationSettings s;
  s.selection = SelectionKind::uniform;
  s.selected_points = 3000;
  s.max_distance = 0.10;
  s.min_distance = 0.06;
  s.max_iterations = 10;
  return s;
}

std::string to_string(MappingStatus status) {
  switch (status) {
    case MappingStatus::initialising:
      return "initialising";
    case MappingStatus::tracking:
      return "tracking";
    case MappingStatus::degraded:
      return "degraded";
    case MappingStatus::lost:
      return "lost";
  }
  return "unknown";
}

IcpMapper::IcpMapper(const IcpMapperSettings& settings)
    : settings_(settings),
      map_(std::make_unique<VoxelMap>(settings.map)),
      view_(*map_, settings.correspondence, settings.view_radius, asked_of_target(settings)),
      anchor_(settings.features),
      last_view_(settings.coarse.frustum || settings.fine.frustum, settings.compares_images(),
                 settings.overlap),
      graph_(settings.graph) {
  check(settings, "icp");
  if (settings.variant != VariantKind::modern) thesis_.emplace(settings.variant, settings.thesis);
}

IcpMapper::Step IcpMapper::step(Utime utime, const ColouredCloud& cloud,
                                const Eigen::Isometry3d& T_robot_camera, const std::optional<Motion>& motion,
                                const FeatureFrame* features, const ColourView* colour) {
  return step(
      utime, geometry_of(cloud), [&cloud] { return cloud; }, T_robot_camera, motion, features, colour);
}

IcpMapper::Step IcpMapper::step(Utime utime, const Cloud& cloud, const Painter& coloured,
                                const Eigen::Isometry3d& T_robot_camera, const std::optional<Motion>& motion,
                                const FeatureFrame* features, const ColourView* colour) {
  // Prepare: trustworthy points, in the robot's frame.
  Cloud usable = usable_points(cloud, settings_.filter);
  move(usable, T_robot_camera);
  const Cloud reduced = voxel_filtered(usable, settings_.voxel_size);

  const ThesisFrame frame{reduced, T_robot_camera, features, colour};
  Step step;
  step.bent = work_on_graph(utime);
  step.thinned = thin();
  if (!started_) {
    start_map(utime, coloured, reduced, T_robot_camera, features, step);
    if (started_ && thesis_) thesis_->add(frame, step.T_world_robot);
    last_view_.keep(colour, T_robot_camera);
    return step;
  }

  // Predict and register.
  Prior prior = predict(T_world_last_, motion, free_motion(utime), settings_.prior);
  std::optional<Prior> anchor;
  if (features != nullptr && settings_.features.enabled && !thesis_)
    anchor = anchor_.locate(*features, prior.T_target_source * T_robot_camera, T_robot_camera);
  if (anchor) {
    const Prior odometry = prior;
    const bool apart = disagreement(odometry, *anchor) > settings_.features.max_disagreement;
    prior = apart ? judged(reduced, odometry, *anchor, T_robot_camera) : fused(odometry, *anchor);
    step.T_world_anchor = anchor->T_target_source;
    step.anchored = !apart || prior.T_target_source.isApprox(anchor->T_target_source, 0);
    if (!step.anchored) anchor.reset();
  }
  last_view_.compare(colour, T_robot_camera);
  const Attempt best = thesis_ ? thesis_attempt(frame, prior.T_target_source)
                               : try_starts(reduced, starts(prior, motion, anchor, features, T_robot_camera),
                                            prior, T_robot_camera);
  step.registration = best.registration;
  step.status = best.status;
  step.quality = best.quality;
  const bool believed = best.status != MappingStatus::lost;
  step.T_world_robot = believed ? best.registration.T_target_source : prior.T_target_source;
  step.covariance =
      believed ? best.registration.covariance : (prior.information + 1e-6 * Matrix6d::Identity()).inverse();

  step.relocalised = bad_steps_ > 0 && best.status == MappingStatus::tracking &&
                     (distance_between(step.T_world_robot, prior.T_target_source) > settings_.max_jump ||
                      angle_between(step.T_world_robot, prior.T_target_source) > settings_.max_turn);

  // Odometry knows the way where the map ends: after a while its prediction is a place to go on from.
  bad_steps_ = best.status == MappingStatus::tracking ? 0 : bad_steps_ + 1;
  const bool reseed = motion && bad_steps_ > settings_.reseed_after &&
                      static_cast<int>(reduced.size()) >= settings_.min_points;
  if (reseed) {
    step.status = MappingStatus::degraded;
    bad_steps_ = 0;
  }
  if (best.status == MappingStatus::tracking || reseed) {
    grow(utime, coloured, reduced, T_robot_camera, features, step);
    if (thesis_) thesis_->add(frame, step.T_world_robot);
  }
  if (best.status == MappingStatus::tracking) {
    look_through(cloud, step.T_world_robot * T_robot_camera);
    last_view_.keep(colour, step.T_world_robot * T_robot_camera);
  }

  const double seconds = static_cast<double>(utime - last_utime_) * 1e-6;
  // A jump to where the robot was found again is no motion that goes on.
  const bool moving = best.status == MappingStatus::tracking && !step.relocalised && seconds > 0;
  velocity_ = moving ? Vector6d(se3_log(T_world_last_.inverse() * step.T_world_robot) / seconds)
                     : Vector6d(Vector6d::Zero());
  T_world_last_ = step.T_world_robot;
  last_utime_ = utime;
  return step;
}

// The last step again, for as long as this one lasts (a second at most).
Eigen::Isometry3d IcpMapper::free_motion(Utime utime) const {
  const double seconds = std::clamp(static_cast<double>(utime - last_utime_) * 1e-6, 0.0, 1.0);
  return se3_exp(seconds * velocity_);
}

std::vector<Eigen::Isometry3d> IcpMapper::starts(const Prior& prior, const std::optional<Motion>& motion,
                                                 const std::optional<Prior>& anchor,
                                                 const FeatureFrame* features,
                                                 const Eigen::Isometry3d& T_robot_camera) {
  std::vector<Eigen::Isometry3d> starts = {prior.T_target_source};
  if (anchor) starts.push_back(anchor->T_target_source);
  if (bad_steps_ == 0) return starts;

  starts.push_back(T_world_last_);
  // Wheels slip by centimetres, they do not jump to another place that happens to look alike.
  if (motion && !motion->visual) return starts;
  if (!anchor && features != nullptr && settings_.features.enabled)
    if (const auto found = anchor_.search(*features, T_robot_camera))
      starts.push_back(found->T_target_source);
  const Eigen::Isometry3d T_camera_robot = T_robot_camera.inverse();
  for (int i = 0; i < settings_.recovery_keyframes && !keyframes_.empty(); ++i)
    starts.push_back(keyframes_[next_recovery_++ % keyframes_.size()].T_world_camera * T_camera_robot);
  for (const Eigen::Isometry3d& T_world_robot : starts) restore(T_world_robot * T_robot_camera);
  return starts;
}

// Share of a sample of points that lie on the map, nearer ones counting more.
double IcpMapper::score(const Cloud& cloud, const Eigen::Isometry3d& T_world_robot) const {
  constexpr std::size_t samples = 200;
  constexpr float reach = 0.12f;
  const Eigen::Isometry3f T = T_world_robot.cast<float>();
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / samples);
  double sum = 0;
  std::size_t count = 0;
  TargetPoint found;
  for (std::size_t i = 0; i < cloud.size(); i += stride, ++count) {
    const Eigen::Vector3f p = T * cloud.points[i];
    if (!map_->find(p, reach, found)) continue;
    if (cloud.has_normals() && found.normal.dot(T.linear() * cloud.normals[i]) < 0.7f) continue;
    sum += 1.0 - static_cast<double>(std::abs(found.normal.dot(p - found.point)) / reach);
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

// Best-looking starts first; the first one that tracks is taken, otherwise the best of all.
IcpMapper::Attempt IcpMapper::try_starts(const Cloud& cloud, std::vector<Eigen::Isometry3d> starts,
                                         const Prior& prior, const Eigen::Isometry3d& T_robot_camera) {
  Attempt best;
  best.registration.T_target_source = prior.T_target_source;
  if (static_cast<int>(cloud.size()) < settings_.min_points) return best;
  if (starts.size() > 1) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < starts.size(); ++i) order.emplace_back(-score(cloud, starts[i]), i);
    std::sort(order.begin(), order.end());
    std::vector<Eigen::Isometry3d> sorted;
    for (const auto& [negative_score, i] : order) sorted.push_back(starts[i]);
    starts = sorted;
  }
  for (const Eigen::Isometry3d& T_start : starts) {
    const Attempt now = attempt(cloud, view_.from(T_start * T_robot_camera), T_start, prior);
    if (now.quality > best.quality || &T_start == &starts.front()) best = now;
    if (best.status == MappingStatus::tracking) break;
  }
  return best;
}

// Odometry slips, and features show things that move: where the two tell different places, the map knows.
Prior IcpMapper::judged(const Cloud& cloud, const Prior& odometry, const Prior& anchor,
                        const Eigen::Isometry3d& T_robot_camera) {
  HypothesisSettings hypotheses;
  hypotheses.coarse = without_views(settings_.coarse);
  hypotheses.fine = without_views(settings_.fine);
  const Target& target = view_.from(odometry.T_target_source * T_robot_camera);
  const HypothesisResult best =
      register_hypotheses(cloud, target, {{odometry, "odometry"}, {anchor, "features"}}, hypotheses);
  return best.origin == "features" ? anchor : odometry;
}

IcpMapper::Attempt IcpMapper::attempt(const Cloud& cloud, const Target& target,
                                      const Eigen::Isometry3d& T_start, const Prior& prior) const {
  // A recovery starts far from the prediction, which then is no knowledge but a wrong guess.
  const bool recovery = distance_between(T_start, prior.T_target_source) > settings_.max_jump ||
                        angle_between(T_start, prior.T_target_source) > settings_.max_turn;
  Prior used = prior;
  if (recovery) {
    used.T_target_source = T_start;
    used.information *= 0.1;
  }
  Attempt result;
  Eigen::Isometry3d T = T_start;
  for (const RegistrationSettings* pass : {&settings_.coarse, &settings_.fine}) {
    result.registration = register_cloud(cloud, target, T, last_view_.possible(*pass), prior_for(*pass, used),
                                         last_view_.views());
    T = result.registration.T_target_source;
  }
  result.quality = result.registration.overlap * inlier_share(result.registration);
  result.status = judge(result.registration, used);
  if (recovery && result.status == MappingStatus::degraded) result.status = MappingStatus::lost;
  return result;
}

// The thesis believes what converges.
IcpMapper::Attempt IcpMapper::thesis_attempt(const ThesisFrame& frame,
                                             const Eigen::Isometry3d& T_predicted) const {
  Attempt result;
  result.registration = thesis_->register_frame(frame, T_predicted);
  result.quality = result.registration.overlap * inlier_share(result.registration);
  if (result.registration.ok()) result.status = MappingStatus::tracking;
  return result;
}

MappingStatus IcpMapper::judge(const RegistrationResult& result, const Prior& prior) const {
  if (!result.ok() || result.overlap < settings_.lost_overlap) return MappingStatus::lost;
  if (distance_between(prior.T_target_source, result.T_target_source) > settings_.max_jump ||
      angle_between(prior.T_target_source, result.T_target_source) > settings_.max_turn)
    return MappingStatus::lost;
  if (result.overlap < settings_.good_overlap || inlier_share(result) < settings_.good_inliers)
    return MappingStatus::degraded;
  return MappingStatus::tracking;
}

}  // namespace lcmslam
