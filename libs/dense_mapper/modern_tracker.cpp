#include <lcmslam/dense_mapper/modern_tracker.hpp>

#include <algorithm>
#include <cmath>

#include <lcmslam/dense_mapper/contradiction.hpp>
#include <lcmslam/dense_mapper/start_hypotheses.hpp>

namespace lcmslam {
namespace {

/// What both passes together ask of a target.
RegistrationSettings asked_of_target(const DenseMapperSettings& settings) {
  RegistrationSettings s = settings.fine;
  s.boundary = s.boundary || settings.coarse.boundary;
  s.colour_scale = std::max(s.colour_scale, settings.coarse.colour_scale);
  return s;
}

bool has_wheels(const DenseFrame& frame) {
  return frame.motion && !frame.motion->visual;
}

}  // namespace

ModernTracker::ModernTracker(const DenseMapperSettings& settings, DeformableMap& map,
                             const KeyframeStore& keyframes)
    : settings_(settings),
      map_(map),
      keyframes_(keyframes),
      view_(map.voxels(), settings.correspondence, settings.view_radius, asked_of_target(settings)),
      passes_(settings),
      anchor_(settings.features),
      last_view_(settings.coarse.frustum || settings.fine.frustum, settings.compares_images(),
                 settings.overlap) {}

Tracked ModernTracker::track(const PreparedFrame& prepared, const Expectation& expected) {
  constexpr double moved = 0.015;  // m, rad: less is noise, and joins the map nowhere else
  last_view_.compare(prepared.frame.colour, prepared.frame.T_robot_camera);
  Tracked tracked = led(prepared, expected);
  if (!expected.T_world_stood || expected.adrift || tracked.status == MappingStatus::lost) return tracked;
  const Eigen::Isometry3d &T_stood = *expected.T_world_stood, &T_led = tracked.registration.T_target_source;
  if (distance_between(T_stood, T_led) < moved && angle_between(T_stood, T_led) < moved) return tracked;
  if (auto standing = what_stands(prepared.cloud, T_stood, T_led, map_.voxels()))
    return by_what_stands({prepared.frame, *std::move(standing)}, expected);
  tracked.pushed = true;
  return tracked;
}

// Where registration leads it.
Tracked ModernTracker::led(const PreparedFrame& prepared, const Expectation& expected) {
  Tracked tracked = on_floor(prepared, expected);
  const bool elsewhere = is_elsewhere(tracked, prepared.frame, expected);
  if (elsewhere || tracked.status == MappingStatus::lost)
    if (auto pushed = as_pushed(prepared, expected)) return *std::move(pushed);
  if (!elsewhere) return tracked;
  if (!has_wheels(prepared.frame)) recognise(prepared.frame, tracked);
  if (!tracked.anchored) tracked.status = MappingStatus::lost;
  return tracked;
}

// Beside where the wheels lead a frame may fit, too: whoever was carried sees walls like those that were
// there. (Beyond a jump registration has not been drawn there, but begun.) Without wheels it was begun at
// keyframes as well, and one that looks alike may stand anywhere.
bool ModernTracker::is_elsewhere(const Tracked& tracked, const DenseFrame& frame,
                                 const Expectation& expected) const {
  if (expected.adrift || tracked.anchored || tracked.status == MappingStatus::lost) return false;
  const Prior& motion = expected.off_ground ? *expected.off_ground : expected.prior;
  const Eigen::Isometry3d off = motion.T_target_source.inverse() * tracked.registration.T_target_source;
  const bool leaps =
      off.translation().norm() > settings_.max_jump || rotation_angle(off) > settings_.max_turn;
  if (leaps == has_wheels(frame)) return false;
  Vector6d variances = motion.information.inverse().diagonal();
  variances.head<2>().setConstant(variances.head<2>().maxCoeff());  // a base may slip aside, too
  return std::sqrt(se3_log(off).cwiseAbs2().cwiseQuotient(variances).sum()) > settings_.max_disagreement;
}

// A robot whose wheels stand may be pushed, or roll on where nothing counts its wheels. Where most of the map
// is hidden the frame fits something else that has moved before it.
std::optional<Tracked> ModernTracker::as_pushed(const PreparedFrame& prepared, const Expectation& expected) {
  if (!expected.pushed || expected.adrift) return std::nullopt;
  const DenseFrame& frame = prepared.frame;
  Tracked tracked = on_floor(prepared, *expected.pushed);
  if (tracked.status != MappingStatus::tracking || is_elsewhere(tracked, frame, *expected.pushed) ||
      !shows_the_map(frame, tracked.registration.T_target_source * frame.T_robot_camera, map_.voxels()))
    return std::nullopt;
  tracked.pushed = true;
  return tracked;
}

Tracked ModernTracker::by_what_stands(const PreparedFrame& standing, Expectation expected) {
  expected.prior.T_target_source = *expected.T_world_stood;
  if (expected.off_ground) expected.off_ground->T_target_source = *expected.T_world_stood;
  return on_floor(standing, expected);
}

Tracked ModernTracker::on_floor(const PreparedFrame& prepared, const Expectation& expected) {
  const Tracked tracked = place(prepared, expected.prior, expected);
  if (!expected.off_ground || tracked.status == MappingStatus::lost) return tracked;

  // Had the floor been right, which is part of what placed the frame, little of the way to it would be left.
  const RegistrationResult& placed = tracked.registration;
  const GroundContact ground(settings_.prior.ground, expected.floor);
  const Floor seen = ground.left_over(placed.T_target_source, placed.covariance);
  if (seen <= expected.floor) return tracked;
  Tracked free = place(prepared, *expected.off_ground, expected);
  free.refused_for = seen;
  return free.status == MappingStatus::tracking ? free : tracked;
}

Tracked ModernTracker::place(const PreparedFrame& prepared, const Prior& prior, const Expectation& expected) {
  const DenseFrame& frame = prepared.frame;
  Tracked result;
  result.prior = prior;
  const std::optional<Prior> anchor = prepared.accompanied ? std::nullopt : ask_features(prepared, result);
  const auto best =
      try_starts(prepared, starts(frame, result.prior, anchor, expected), result.prior, expected.adrift);
  result.registration = best.registration;
  result.status = best.status;
  result.quality = best.quality;
  if (expected.adrift) confirm(frame, result);
  return result;
}

// Walls look alike: whoever may be anywhere has found his place where the features say so, too. Where there
// are none to ask, nothing that is seen may speak against it, and the mapper waits for more frames that fit.
void ModernTracker::confirm(const DenseFrame& frame, Tracked& result) {
  result.anchored = false;
  const bool fits = result.status == MappingStatus::tracking;
  result.status = MappingStatus::lost;
  if (!fits) return;
  recognise(frame, result);
  if (result.anchored || (!can_recognise(frame, result) && is_certain(frame, result.registration)))
    result.status = MappingStatus::tracking;
}

bool ModernTracker::can_recognise(const DenseFrame& frame, const Tracked& result) const {
  return frame.features && settings_.features.enabled &&
         anchor_.can_recognise(*frame.features, result.registration.T_target_source * frame.T_robot_camera);
}

// The floor fits everywhere, and what is looked through is not there.
bool ModernTracker::is_certain(const DenseFrame& frame, const RegistrationResult& placed) const {
  constexpr double most_seen_through = 0.2;  // share
  return placed.degenerate.empty() && seen_through(frame, placed.T_target_source * frame.T_robot_camera,
                                                   map_.voxels()) < most_seen_through;
}

// Whether features say that it is where its cloud fits.
void ModernTracker::recognise(const DenseFrame& frame, Tracked& result) {
  constexpr double same_place = 0.1;  // m and rad
  if (!frame.features || !settings_.features.enabled) return;
  const Eigen::Isometry3d& T_world_robot = result.registration.T_target_source;
  const auto place =
      anchor_.recognise(*frame.features, T_world_robot * frame.T_robot_camera, frame.T_robot_camera);
  result.anchored = place && distance_between(T_world_robot, place->T_target_source) < same_place &&
                    angle_between(T_world_robot, place->T_target_source) < same_place;
  if (result.anchored) result.T_world_anchor = place->T_target_source;
}

// Where keyframes' features place the robot, if that is believed; the prior then knows it.
std::optional<Prior> ModernTracker::ask_features(const PreparedFrame& prepared, Tracked& result) {
  const DenseFrame& frame = prepared.frame;
  if (!frame.features || !settings_.features.enabled) return std::nullopt;
  const Prior odometry = result.prior;
  const auto anchor =
      anchor_.locate(*frame.features, odometry.T_target_source * frame.T_robot_camera, frame.T_robot_camera);
  if (!anchor) return std::nullopt;
  const bool apart = disagreement(odometry, *anchor) > settings_.features.max_disagreement;
  result.prior = apart ? judged_by_map(prepared, odometry, *anchor) : fused(odometry, *anchor);
  result.T_world_anchor = anchor->T_target_source;
  result.anchored = !apart || result.prior.T_target_source.isApprox(anchor->T_target_source, 0);
  return result.anchored ? anchor : std::nullopt;
}

// Odometry slips, and features show things that move: where the two tell different places, the map knows.
Prior ModernTracker::judged_by_map(const PreparedFrame& prepared, const Prior& odometry,
                                   const Prior& anchor) {
  HypothesisSettings hypotheses;
  hypotheses.coarse = without_views(settings_.coarse);
  hypotheses.fine = without_views(settings_.fine);
  const Target& target = view_.from(odometry.T_target_source * prepared.frame.T_robot_camera);
  const HypothesisResult best =
      register_hypotheses(prepared.cloud, target, {{odometry, "odometry"}, {anchor, "features"}}, hypotheses);
  return best.origin == "features" ? anchor : odometry;
}

std::vector<Eigen::Isometry3d> ModernTracker::starts(const DenseFrame& frame, const Prior& prior,
                                                     const std::optional<Prior>& anchor,
                                                     const Expectation& expected) {
  std::vector<Eigen::Isometry3d> starts = {prior.T_target_source};
  if (anchor) starts.push_back(anchor->T_target_source);
  if (expected.bad_steps == 0 && !expected.adrift) return starts;

  starts.push_back(expected.T_world_last);
  // Wheels slip by centimetres, they do not jump to another place that happens to look alike.
  if (has_wheels(frame) && !expected.adrift) return starts;
  if (!anchor && frame.features && settings_.features.enabled)
    if (const auto found = anchor_.search(*frame.features, frame.T_robot_camera))
      starts.push_back(found->T_target_source);
  const auto& keyframes = keyframes_.all();
  const Eigen::Isometry3d T_camera_robot = frame.T_robot_camera.inverse();
  for (int i = 0; i < settings_.recovery_keyframes && !keyframes.empty(); ++i)
    starts.push_back(keyframes[next_recovery_++ % keyframes.size()].T_world_camera * T_camera_robot);
  for (const Eigen::Isometry3d& T_world_robot : starts)
    map_.restore(keyframes, T_world_robot * frame.T_robot_camera);
  return starts;
}

// Share of a sample of points that lie on the map, nearer ones counting more.
double ModernTracker::score(const Cloud& cloud, const Eigen::Isometry3d& T_world_robot) const {
  constexpr std::size_t samples = 200;
  constexpr float reach = 0.12f;
  const Eigen::Isometry3f T = T_world_robot.cast<float>();
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / samples);
  double sum = 0;
  std::size_t count = 0;
  TargetPoint found;
  for (std::size_t i = 0; i < cloud.size(); i += stride, ++count) {
    const Eigen::Vector3f p = T * cloud.points[i];
    if (!map_.voxels().find(p, reach, found)) continue;
    if (cloud.has_normals() && found.normal.dot(T.linear() * cloud.normals[i]) < 0.7f) continue;
    sum += 1.0 - static_cast<double>(std::abs(found.normal.dot(p - found.point)) / reach);
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

void ModernTracker::sort_by_score(const Cloud& cloud, std::vector<Eigen::Isometry3d>& starts) const {
  if (starts.size() < 2) return;
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(starts.size());
  for (std::size_t i = 0; i < starts.size(); ++i) order.emplace_back(-score(cloud, starts[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<Eigen::Isometry3d> sorted;
  sorted.reserve(order.size());
  for (const auto& [negative_score, i] : order) sorted.push_back(starts[i]);
  starts = std::move(sorted);
}

// Best-looking starts first; the first one that tracks, and certainly where the robot may be anywhere, is
// taken, otherwise the best of all.
RegistrationPasses::Attempt ModernTracker::try_starts(const PreparedFrame& prepared,
                                                      std::vector<Eigen::Isometry3d> starts,
                                                      const Prior& prior, bool adrift) {
  RegistrationPasses::Attempt best;
  best.registration.T_target_source = prior.T_target_source;
  const Cloud& cloud = prepared.cloud;
  if (static_cast<int>(cloud.size()) < settings_.min_points) return best;
  sort_by_score(cloud, starts);
  for (const Eigen::Isometry3d& T_start : starts) {
    const Target& target = view_.from(T_start * prepared.frame.T_robot_camera);
    const auto now = passes_.run(prepared, target, T_start, prior, last_view_);
    const bool tracks = now.status == MappingStatus::tracking;
    if (tracks && (!adrift || is_certain(prepared.frame, now.registration))) return now;
    if (now.quality > best.quality || &T_start == &starts.front()) best = now;
  }
  return best;
}

void ModernTracker::accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot,
                           bool registered) {
  if (registered) last_view_.keep(prepared.frame.colour, T_world_robot * prepared.frame.T_robot_camera);
}

void ModernTracker::add_keyframe(const FeatureFrame& features, const Eigen::Isometry3d& T_world_camera,
                                 int node) {
  anchor_.add(T_world_camera, features, node);
}

void ModernTracker::deform(const KeyframeGraph::Correction& correction) {
  view_.show(map_.voxels());
  anchor_.deform(correction);
  last_view_.move(correction.back());
}

void ModernTracker::renumber(const KeyframeGraph::Thinned& thinned) {
  anchor_.renumber(thinned.gone, thinned.index);
}

}  // namespace lcmslam
