#include <lcmslam/dense_mapper/dense_mapper.hpp>

#include <algorithm>

#include <lcmslam/features/strongest_features.hpp>
#include <lcmslam/pose_graph/error_factors.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

KeyframeGraph::PlacedBy placed_by(const DenseMapper::Step& step) {
  if (step.reseeded) return KeyframeGraph::PlacedBy::odometry;
  return step.relocalised ? KeyframeGraph::PlacedBy::relocalisation : KeyframeGraph::PlacedBy::registration;
}

}  // namespace

DenseMapper::DenseMapper(const DenseMapperSettings& settings)
    : settings_(settings),
      motion_(settings.prior),
      ground_(settings.prior.ground),
      keyframes_(settings),
      map_(settings),
      tracker_(make_tracker(settings, map_, keyframes_)),
      changed_space_(settings),
      carried_(settings),
      graph_(settings.graph) {
  check(settings_, "icp");
}

DenseMapper::Step DenseMapper::step(const DenseFrame& frame) {
  // Prepare: the points that can be trusted, and the map as the graph has corrected it meanwhile.
  PreparedFrame prepared = prepare(frame);
  prepared.accompanied = wheel_hold_.is_accompanied(prepared, motion_.adrift());
  Step step;
  step.deformed = work_on_graph(frame.utime);
  step.thinned = thin();
  if (graph_.nodes().empty()) {
    start_map(prepared, step);
    return step;
  }

  // Predict: where odometry, or the velocity so far, leads.
  motion_.look_for_gap(frame.utime, frame.motion);
  const Expectation expected = expect(frame);

  // Register: where the cloud fits the map.
  Tracked tracked = tracker_->track(prepared, expected);
  wheel_hold_.hold(prepared, expected, tracked);

  // Judge: what is believed of it, and whether the frame may join the map.
  const bool joins = judge(tracked, expected, prepared, step);
  stand_on_ground(tracked, step);
  const bool registered = step.status == MappingStatus::tracking;

  // Grow: the frame joins the map, and what it sees through goes.
  if (joins) {
    motion_.found();
    grow(prepared, step);
    accept(prepared, step.T_world_robot, registered);
  } else {
    motion_.lose(frame.utime, frame.motion, step.status != MappingStatus::lost);
  }
  if (registered)
    changed_space_.look_through(frame.cloud, step.T_world_robot * frame.T_robot_camera, map_, keyframes_,
                                first_node_here());
  // Tell: how wrong the pose may be in the whole map, and where it is as seen by whoever must not see it
  // jump.
  tell_covariance(frame.T_robot_camera, step);
  tell_local_pose(tracked.pushed ? *expected.pushed : expected, step);

  // Where wheels hold it, small steps of registration do not add up.
  const bool stands =
      expected.T_world_stood && !step.adrift && !step.relocalised && !(registered && tracked.pushed);
  motion_.stand(stands ? *expected.T_world_stood : step.T_world_robot);
  // A jump to where the robot was found again is no motion that goes on.
  motion_.observe(frame.utime, step.T_world_robot, registered && !step.relocalised);
  step.hangs_on_odometry = hangs_on_odometry();
  if (registered && step.hangs_on_odometry) step.status = MappingStatus::degraded;
  return step;
}

PreparedFrame DenseMapper::prepare(const DenseFrame& frame) const {
  Cloud usable = usable_points(frame.cloud, settings_.filter);
  move(usable, frame.T_robot_camera);
  if (settings_.voxel_size == 0) return {frame, std::move(usable)};
  return {frame, voxel_filtered(usable, settings_.voxel_size)};
}

Expectation DenseMapper::expect(const DenseFrame& frame) const {
  Expectation expected = expect(frame, false);
  if (motion_.is_held(frame.motion)) {
    expected.T_world_stood = motion_.T_world_stood() * frame.motion->T_from_to;
    expected.pushed = std::make_shared<const Expectation>(expect(frame, true));
  }
  return expected;
}

Expectation DenseMapper::expect(const DenseFrame& frame, bool pushed) const {
  Expectation expected;
  expected.T_world_last = motion_.T_world_last();
  expected.bad_steps = bad_steps_;
  expected.adrift = motion_.adrift();
  if (settings_.prior.planar) expected.floor = ground_.floor();
  expected.prior = motion_.predict(frame.utime, frame.motion, expected.floor, pushed);
  if (expected.floor != Floor::free)
    expected.off_ground = motion_.predict(frame.utime, frame.motion, Floor::free, pushed);
  expected.step = motion_.predict_step(frame.utime, frame.motion, expected.floor, pushed);
  return expected;
}

// A robot on wheels stands on the floor that is believed until what it measures refuses that.
void DenseMapper::stand_on_ground(const Tracked& tracked, Step& step) {
  if (!settings_.prior.planar) return;
  const bool believed = step.status == MappingStatus::tracking;
  if (believed && tracked.refused_for)
    ground_.leave_for(*tracked.refused_for);
  else if (believed)
    ground_.observe(step.T_world_robot, step.covariance);
  step.floor = ground_.floor();
}

void DenseMapper::start_map(const PreparedFrame& prepared, Step& step) {
  motion_.observe(prepared.frame.utime, step.T_world_robot, false);
  if (static_cast<int>(prepared.cloud.size()) < settings_.min_points) return;
  if (settings_.prior.planar)
    graph_.set_ground(GroundConstraint{prepared.frame.T_robot_camera.inverse(),
                                       settings_.prior.ground,
                                       {},
                                       settings_.mount_error.sigmas(prepared.frame.T_robot_camera)});
  step.quality = 1;
  step.status = MappingStatus::tracking;
  add_node(prepared, true, step);
  map_.insert(prepared.cloud, Eigen::Isometry3d::Identity(), 0);
  accept(prepared, step.T_world_robot, true);
  local_.advance(step.T_world_robot, {});
}

void DenseMapper::accept(const PreparedFrame& prepared, const Eigen::Isometry3d& T_world_robot,
                         bool registered) {
  tracker_->accept(prepared, T_world_robot, registered);
  if (tracker_->grows()) keyframes_.grow(tracker_->joined());
}

bool DenseMapper::judge(const Tracked& tracked, const Expectation& expected, const PreparedFrame& prepared,
                        Step& step) {
  const bool was_adrift = motion_.adrift();
  step.adrift = was_adrift && !is_found(tracked, prepared.frame.utime);
  const bool tracking = tracked.status == MappingStatus::tracking && !step.adrift;
  const bool believed = tracked.status != MappingStatus::lost;
  step.registration = tracked.registration;
  step.status = step.adrift ? MappingStatus::lost : tracked.status;
  step.quality = tracked.quality;
  step.anchored = tracked.anchored;
  step.held = tracked.held;
  step.T_world_anchor = tracked.T_world_anchor;
  // What features say of who is adrift is believed where the cloud fits, too, or not at all.
  const Prior& prior = step.adrift ? expected.prior : tracked.prior;
  step.T_world_robot = believed ? tracked.registration.T_target_source : prior.T_target_source;
  step.covariance = believed ? tracked.registration.covariance : uncertain(prior);
  step.blind = static_cast<int>(prepared.cloud.size()) < settings_.min_points;
  if (tracker_->searches_map()) carried_.observe(prepared, tracked, tracking, was_adrift, map_.voxels());
  // Only the wheels tell then.
  step.blocked = carried_.blocked();
  if (step.blocked) {
    step.status = MappingStatus::degraded;
    step.T_world_robot = prior.T_target_source;
    step.covariance = uncertain(prior);
  }
  if (carried_.carried()) {
    motion_.be_carried(settings_.carried_after);
    step.adrift = step.carried = true;
    step.status = MappingStatus::lost;
  }
  // Where it fits is a candidate then, no place that is known.
  if (step.adrift) step.covariance = uncertain(expected.prior);
  if (step.adrift && !was_adrift) step.covariance += motion_.drift();
  step.unplaced = tracked.status == MappingStatus::tracking ? 0 : carried_.unplaced();
  const Eigen::Isometry3d& T_expected = expected.prior.T_target_source;
  const bool leaps = distance_between(step.T_world_robot, T_expected) > settings_.max_jump ||
                     angle_between(step.T_world_robot, T_expected) > settings_.max_turn;
  // The first candidate has leapt; where the others lie that one has led.
  strayed_ = was_adrift && (strayed_ || leaps);
  step.relocalised = (bad_steps_ > 0 || was_adrift) && tracking && (leaps || strayed_);

  // Odometry knows the way where the map ends: after a while its prediction is a place to go on from.
  // A camera that was covered, or sees what stands close before the map, has not seen that yet.
  bad_steps_ = tracking ? 0 : bad_steps_ + 1;
  misfits_ = tracking ? 0 : misfits_ + (step.blind || step.blocked || tracked.held ? 0 : 1);
  step.reseeded = motion_.knows(prepared.frame.motion) && !step.adrift && !step.blind &&
                  !carried_.contradicted() && misfits_ > settings_.reseed_after;
  if (step.reseeded) {
    step.status = MappingStatus::degraded;
    step.covariance = prior.information.inverse();
    bad_steps_ = misfits_ = 0;
    const int first = graph_.nodes().back().id + 1;
    if (settings_.graph.enabled && (hanging_from_.empty() || hanging_from_.back() < first))
      hanging_from_.push_back(first);
  }
  return tracking || step.reseeded;
}

// What grows from where odometry led fits itself; whether it lies where it should in the map, the graph tells
// when it has compared both.
bool DenseMapper::hangs_on_odometry() {
  if (!hanging_from_.empty() && !map_.deforming() && graph_.ties(hanging_from_)) hanging_from_.clear();
  return !hanging_from_.empty();
}

// Of the part of the map whose place around the robot is known.
int DenseMapper::first_node_here() const {
  if (hanging_from_.empty()) return 0;
  const auto& nodes = graph_.nodes();
  const auto first =
      std::find_if(nodes.begin(), nodes.end(), [&](const auto& n) { return n.id >= hanging_from_.back(); });
  return static_cast<int>(first - nodes.begin());
}

// After a gap: the cloud fits the map where features say so too or, without features, in many frames in a
// row, of which a slow camera gives fewer in the same time.
bool DenseMapper::is_found(const Tracked& tracked, Utime utime) {
  constexpr int least = 3;                // frames
  constexpr Utime long_time = 1'000'000;  // us
  if (tracked.status != MappingStatus::tracking) {
    placed_in_a_row_ = 0;
    return false;
  }
  if (placed_in_a_row_++ == 0) placed_since_ = utime;
  const bool long_enough = placed_in_a_row_ >= least && utime - placed_since_ >= long_time;
  if (!tracked.anchored && !long_enough && placed_in_a_row_ <= settings_.reseed_after) return false;
  placed_in_a_row_ = 0;
  return true;
}

// The map in sight stands on the newest node and errs as that does; registration errs beside it, and so does
// the head's place on the robot.
void DenseMapper::tell_covariance(const Eigen::Isometry3d& T_robot_camera, Step& step) const {
  const KeyframeGraph::Node& newest = graph_.nodes().back();
  const Eigen::Isometry3d T_world_camera = step.T_world_robot * T_robot_camera;
  const PoseError error =
      carried_along(newest.error, {newest.T_world_camera.inverse() * T_world_camera, Matrix6d::Zero()});
  step.map_covariance = covariance_at(error, T_world_camera, T_robot_camera);
  step.local_covariance = step.status == MappingStatus::tracking
                              ? frame_error(step.covariance, settings_.graph.optimiser)
                              : step.covariance;
  // A new node's own covariance has its registration in it.
  if (!step.node) step.map_covariance += step.local_covariance;
}

Matrix6d DenseMapper::covariance_at(const PoseError& error, const Eigen::Isometry3d& T_world_camera,
                                    const Eigen::Isometry3d& T_robot_camera) const {
  return robot_covariance(error, graph_.nodes().front().T_world_camera.inverse() * T_world_camera,
                          T_robot_camera, settings_.mount_error.sigmas(T_robot_camera));
}

Matrix6d DenseMapper::node_covariance(const KeyframeGraph::Node& node,
                                      const Eigen::Isometry3d& T_robot_camera) const {
  const Matrix6d A = adjoint(T_robot_camera.inverse());
  return A * covariance_at(node.map_error, node.T_world_camera, T_robot_camera) * A.transpose();
}

void DenseMapper::tell_local_pose(const Expectation& expected, Step& step) {
  const Eigen::Isometry3d T_last_now = expected.T_world_last.inverse() * expected.step.T_target_source;
  local_.advance(step.T_world_robot, {T_last_now, uncertain(expected.step)});
  step.T_world_local = local_.T_map_local();
  step.T_local_robot = local_.T_local_robot();
}

void DenseMapper::grow(const PreparedFrame& prepared, Step& step) {
  const Eigen::Isometry3d& T = step.T_world_robot;
  const Eigen::Isometry3d T_world_camera = T * prepared.frame.T_robot_camera;
  // While nothing can be thinned, too many must not become more.
  const bool too_many = (map_.deforming() || graph_.at_work()) &&
                        keyframes_.all().size() > static_cast<std::size_t>(settings_.graph.max_keyframes);
  const bool keyframe = !too_many && keyframes_.is_due(T_world_camera, step.registration.overlap);
  // What odometry placed belongs to a node of its own, however near another stands.
  if (keyframe || step.reseeded || keyframes_.is_far(T_world_camera, graph_.nodes().back().T_world_camera))
    add_node(prepared, keyframe, step);
  // What odometry placed does not fit what is there: a robot that stands would not fit for ever.
  if (step.reseeded || distance_between(T, T_world_inserted_) >= settings_.insert_distance ||
      angle_between(T, T_world_inserted_) >= settings_.insert_angle) {
    map_.insert(transformed(prepared.cloud, T), T, static_cast<int>(graph_.nodes().size()) - 1);
    T_world_inserted_ = T;
  }
}

// Where the camera comes by again, a node keeps the path's place in the graph, without another cloud.
void DenseMapper::add_node(const PreparedFrame& prepared, bool keyframe, Step& step) {
  const DenseFrame& frame = prepared.frame;
  const Eigen::Isometry3d T_world_camera = step.T_world_robot * frame.T_robot_camera;
  const Matrix6d A = adjoint(frame.T_robot_camera.inverse());  // from the robot's body frame to the camera's
  KeyframeView view;
  view.cloud = transformed(prepared.cloud, frame.T_robot_camera.inverse());
  view.noise_left = frame.noise_left;
  if (frame.features) view.features = strongest(*frame.features, settings_.keyframe_features);
  map_.restore(keyframes_.all(), T_world_camera);
  view.shows = shown_keyframes(transformed(prepared.cloud, step.T_world_robot));
  const int node = graph_.add(frame.utime, T_world_camera, A * step.covariance * A.transpose(),
                              std::move(view), keyframe, step.floor, placed_by(step));
  step.node = true;
  step.keyframe = keyframe;
  if (!keyframe) return;
  if (tracker_->grows())
    keyframes_.begin(node, frame.utime, T_world_camera);
  else
    keyframes_.add(node, frame.utime, T_world_camera, usable_points(frame.colouriser(), settings_.filter));
  if (frame.features)
    tracker_->add_keyframe(strongest(*frame.features, settings_.keyframe_features), T_world_camera, node);
}

// Keyframes that own a good part of the surfaces that a cloud (map coordinates) lies on, those of the most
// points first. What other nodes have inserted belongs to the keyframe before them.
std::vector<int> DenseMapper::shown_keyframes(const Cloud& cloud) const {
  constexpr std::size_t asked = 300;
  constexpr int least = 30;
  const std::vector<int> owners = map_.voxels().owners(cloud, asked);
  const std::vector<KeyframeGraph::Node>& nodes = graph_.nodes();
  std::vector<std::pair<int, int>> votes;  // and keyframe
  for (std::size_t i = 0; i < std::min(owners.size(), nodes.size()); ++i) {
    if (nodes[i].keyframe || votes.empty()) votes.emplace_back(0, static_cast<int>(i));
    votes.back().first += owners[i];
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<int> keyframes;
  for (const auto& [count, node] : votes)
    if (count >= least) keyframes.push_back(node);
  return keyframes;
}

void DenseMapper::add_features(const FeatureFrame& features, Utime utime) {
  if (graph_.nodes().empty() || graph_.nodes().back().utime != utime) return;
  const auto node = static_cast<int>(graph_.nodes().size()) - 1;
  const FeatureFrame kept = strongest(features, settings_.keyframe_features);
  if (!graph_.add_features(node, kept)) return;
  const Keyframe& newest = keyframes_.all().back();
  if (newest.node == node) tracker_->add_keyframe(kept, newest.T_world_camera, node);
}

// The graph's correction, the map deformed by it, then all that stands in the map: one after the other, each
// at its message time.
bool DenseMapper::work_on_graph(Utime utime) {
  if (map_.is_due(utime)) {
    deform(map_.finish_deforming());
    return true;
  }
  if (map_.deforming()) return false;
  if (auto correction = graph_.work(utime)) map_.begin_deforming(std::move(*correction), utime);
  return false;
}

void DenseMapper::deform(const KeyframeGraph::Correction& correction) {
  keyframes_.deform(correction);
  changed_space_.deform(correction);
  tracker_->deform(correction);
  graph_.apply(correction);
  motion_.deform(correction.back());
  local_.change_map(motion_.T_world_last());
  T_world_inserted_ = correction.back() * T_world_inserted_;
}

// Nodes that others cover go from the graph; what belongs to them belongs to the nearest keyframe then.
bool DenseMapper::thin() {
  keyframes_.merge_next();
  if (map_.deforming()) return false;  // it is being read, and the nodes' places are about to change
  const auto thinned = graph_.thin({settings_.keyframe_distance, settings_.keyframe_angle});
  if (!thinned) return false;
  keyframes_.thin(*thinned);
  changed_space_.renumber(*thinned);
  tracker_->renumber(*thinned);
  map_.renumber(thinned->index);
  return true;
}

bool DenseMapper::finish() {
  const bool was_deforming = map_.deforming();
  if (was_deforming) deform(map_.finish_deforming());
  auto correction = graph_.finish();
  if (correction) deform(map_.deform(std::move(*correction)));
  while (keyframes_.merging()) keyframes_.merge_next();
  changed_space_.finish(map_.voxels(), keyframes_);
  return was_deforming || correction.has_value();
}

std::size_t DenseMapper::memory_bytes() const {
  return map_.memory_bytes() + tracker_->memory_bytes() + graph_.memory_bytes() + keyframes_.memory_bytes() +
         changed_space_.memory_bytes();
}

}  // namespace lcmslam
