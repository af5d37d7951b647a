// IcpMapper: how its map grows, is given back, and bends with the graph.

#include <algorithm>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/dense_mapper/icp_mapper.hpp>
#include <lcmslam/features/strongest_features.hpp>

namespace lcmslam {

void IcpMapper::start_map(Utime utime, const Painter& coloured, const Cloud& cloud,
                          const Eigen::Isometry3d& T_robot_camera, const FeatureFrame* features, Step& step) {
  last_utime_ = utime;
  if (static_cast<int>(cloud.size()) < settings_.min_points) return;
  started_ = true;
  if (settings_.prior.planar) graph_.set_ground(T_robot_camera.inverse());
  step.quality = 1;
  step.status = MappingStatus::tracking;
  add_node(utime, coloured, cloud, T_robot_camera, features, true, step);
  insert(cloud, Eigen::Vector3d::Zero(), 0);
}

void IcpMapper::grow(Utime utime, const Painter& coloured, const Cloud& cloud,
                     const Eigen::Isometry3d& T_robot_camera, const FeatureFrame* features, Step& step) {
  const Eigen::Isometry3d& T = step.T_world_robot;
  const Eigen::Isometry3d T_world_camera = T * T_robot_camera;
  const bool keyframe = keyframe_due(T_world_camera, step.registration.overlap);
  if (keyframe || is_far(T_world_camera, graph_.nodes().back().T_world_camera, 1))
    add_node(utime, coloured, cloud, T_robot_camera, features, keyframe, step);
  if (distance_between(T, T_world_inserted_) >= settings_.insert_distance ||
      angle_between(T, T_world_inserted_) >= settings_.insert_angle) {
    insert(transformed(cloud, T), T.translation(), static_cast<int>(graph_.nodes().size()) - 1);
    T_world_inserted_ = T;
  }
}

// Where the camera comes by again, a node keeps the path's place in the graph, without another cloud.
void IcpMapper::add_node(Utime utime, const Painter& coloured, const Cloud& cloud,
                         const Eigen::Isometry3d& T_robot_camera, const FeatureFrame* features, bool keyframe,
                         Step& step) {
  const Eigen::Isometry3d T_world_camera = step.T_world_robot * T_robot_camera;
  const Matrix6d A = adjoint(T_robot_camera.inverse());  // from the robot's body frame to the camera's
  KeyframeView view;
  view.cloud = transformed(cloud, T_robot_camera.inverse());
  if (features != nullptr) view.features = strongest(*features, settings_.keyframe_features);
  restore(T_world_camera);
  const int node =
      graph_.add(utime, T_world_camera, A * step.covariance * A.transpose(), std::move(view), keyframe);
  step.node = true;
  step.keyframe = keyframe;
  if (!keyframe) return;
  const ColouredCloud usable = usable_points(coloured(), settings_.filter);
  keyframes_.push_back({node, utime, T_world_camera, voxel_filtered(usable, settings_.keyframe_voxel),
                        settings_.keyframe_voxel});
  ++keyframes_made_;
  bound_keyframes(T_world_camera);
  if (features != nullptr)
    anchor_.add(T_world_camera, strongest(*features, settings_.keyframe_features), node);
}

void IcpMapper::add_features(const FeatureFrame& features, Utime utime) {
  if (graph_.nodes().empty() || graph_.nodes().back().utime != utime) return;
  const auto node = static_cast<int>(graph_.nodes().size()) - 1;
  const FeatureFrame kept = strongest(features, settings_.keyframe_features);
  if (!graph_.add_features(node, kept)) return;
  if (keyframes_.back().id == node) anchor_.add(keyframes_.back().T_world_camera, kept, node);
}

// Far from every keyframe, or (with half the way gone) where little is known.
bool IcpMapper::keyframe_due(const Eigen::Isometry3d& T_world_camera, double overlap) const {
  const double share = overlap < settings_.keyframe_overlap ? 0.5 : 1.0;
  return std::all_of(keyframes_.begin(), keyframes_.end(),
                     [&](const Keyframe& k) { return is_far(T_world_camera, k.T_world_camera, share); });
}

bool IcpMapper::is_far(const Eigen::Isometry3d& T_world_camera, const Eigen::Isometry3d& T_world_other,
                       double share) const {
  return distance_between(T_world_other, T_world_camera) >= share * settings_.keyframe_distance ||
         angle_between(T_world_other, T_world_camera) >= share * settings_.keyframe_angle;
}

void IcpMapper::insert(Cloud cloud_in_world, const Eigen::Vector3d& view_point, int node) {
  if (bending_.valid())
    insertions_.push_back({std::move(cloud_in_world), view_point, node});
  else
    map_->insert(cloud_in_world, view_point, node);
}

// The map is bounded and forgets what is far; on the way back the keyframes there give it back.
void IcpMapper::restore(const Eigen::Isometry3d& T_world_camera) {
  constexpr double reach = 3;          // m
  constexpr std::size_t samples = 50;  // of a keyframe's points
  if (!map_->has_forgotten()) return;
  for (const Keyframe& keyframe : keyframes_) {
    if (distance_between(keyframe.T_world_camera, T_world_camera) > reach || keyframe.cloud.size() == 0)
      continue;
    std::size_t known = 0, asked = 0;
    TargetPoint found;
    const Eigen::Isometry3f T = keyframe.T_world_camera.cast<float>();
    for (std::size_t i = 0; i < keyframe.cloud.size(); i += 1 + keyframe.cloud.size() / samples, ++asked)
      known += map_->find(T * keyframe.cloud.points[i], 0.1f, found) ? 1 : 0;
    if (2 * known >= asked) continue;
    Cloud cloud = geometry_of(keyframe.cloud, keyframe.T_world_camera);
    if (map_->has_intensities()) cloud.intensities = intensities_of(keyframe.cloud);
    insert(voxel_filtered(cloud, settings_.voxel_size), T_world_camera.translation(), keyframe.id);
  }
}

// Twice the voxel, about a quarter of the points: those far away first, until a tenth of the limit is free.
void IcpMapper::bound_keyframes(const Eigen::Isometry3d& T_world_camera) {
  constexpr double coarsest = 1;  // m
  double points = 0;
  for (const Keyframe& keyframe : keyframes_) points += static_cast<double>(keyframe.cloud.size());
  if (points <= settings_.keyframe_points) return;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < keyframes_.size(); ++i)
    order.emplace_back(-distance_between(keyframes_[i].T_world_camera, T_world_camera), i);
  std::sort(order.begin(), order.end());
  bool thinned = true;
  while (thinned) {
    thinned = false;
    for (const auto& [nearness, i] : order) {
      Keyframe& keyframe = keyframes_[i];
      if (points <= 0.9 * settings_.keyframe_points) return;
      if (keyframe.voxel > coarsest) continue;
      points -= static_cast<double>(keyframe.cloud.size());
      keyframe.voxel *= 2;
      keyframe.cloud = voxel_filtered(keyframe.cloud, keyframe.voxel);
      points += static_cast<double>(keyframe.cloud.size());
      thinned = true;
    }
  }
}

// The graph's correction, the map bent by it, then all that stands in the map: one after the other, each at
// its message time.
bool IcpMapper::work_on_graph(Utime utime) {
  if (bending_.valid()) {
    if (utime < bent_at_) return false;
    bend(correction_);
    return true;
  }
  auto correction = graph_.work(utime);
  if (!correction) return false;
  correction_ = std::move(*correction);
  const double seconds =
      settings_.bend_time + settings_.bend_time_per_surfel * static_cast<double>(map_->size());
  bent_at_ = utime + static_cast<Utime>(1e6 * seconds);
  bending_ = std::async(std::launch::async, [map = map_.get(), &correction = correction_] {
    return std::make_unique<VoxelMap>(map->bent(correction));
  });
  return false;
}

void IcpMapper::bend(const KeyframeGraph::Correction& correction) {
  map_ = bending_.get();
  view_.show(*map_);
  const auto move_of = [&](int node) -> const Eigen::Isometry3d& {
    return correction[std::min(static_cast<std::size_t>(node), correction.size() - 1)];
  };
  for (Insertion& insertion : insertions_) {
    const Eigen::Isometry3d& T = move_of(insertion.node);
    map_->insert(transformed(insertion.cloud, T), T * insertion.view_point, insertion.node);
  }
  insertions_.clear();
  for (Keyframe& keyframe : keyframes_)
    keyframe.T_world_camera = move_of(keyframe.id) * keyframe.T_world_camera;
  for (auto* places : {&gone_, &swept_})
    for (VoxelMap::Gone& place : *places) place.point = move_of(place.anchor).cast<float>() * place.point;
  if (!swept_.empty()) index_swept();
  for (Keyframe& keyframe : retired_)
    keyframe.T_world_camera = move_of(keyframe.id) * keyframe.T_world_camera;
  anchor_.bend(correction);
  graph_.apply(correction);
  const Eigen::Isometry3d& T_newest = correction.back();
  T_world_last_ = T_newest * T_world_last_;
  T_world_inserted_ = T_newest * T_world_inserted_;
  last_view_.move(T_newest);
}

bool IcpMapper::finish() {
  const bool moved = finish_graph();
  while (!retired_.empty()) merge_next_retired();
  begin_sweep();
  while (!swept_.empty()) clean_next_keyframe();
  return moved;
}

bool IcpMapper::finish_graph() {
  bool moved = false;
  if (bending_.valid()) {
    bend(correction_);
    moved = true;
  }
  auto correction = graph_.finish();
  if (!correction) return moved;
  correction_ = std::move(*correction);
  bending_ =
      std::async(std::launch::deferred, [&] { return std::make_unique<VoxelMap>(map_->bent(correction_)); });
  bend(correction_);
  return true;
}

}  // namespace lcmslam
