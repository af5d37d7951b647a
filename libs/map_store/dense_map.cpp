#include <lcmslam/map_store/dense_map.hpp>

#include <algorithm>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/cloud/voxel_average.hpp>

namespace lcmslam {
namespace {

constexpr int max_tiles = 100'000;

void require(bool condition, std::int32_t id, const std::string& problem) {
  if (!condition) throw std::invalid_argument("keyframe " + std::to_string(id) + ": " + problem);
}

void check_pose(std::int32_t id, const Eigen::Isometry3d& pose) {
  require(pose.matrix().allFinite(), id, "the pose must be finite");
}

void check(const KeyframeTile& tile) {
  const DenseKeyframe& part = tile.part;
  require(tile.tiles >= 1 && tile.tiles <= max_tiles && tile.tile >= 0 && tile.tile < tile.tiles, part.id,
          "tile " + std::to_string(tile.tile) + " of " + std::to_string(tile.tiles) +
              " must be from 0 to tiles - 1, at most " + std::to_string(max_tiles) + " tiles");
  check_pose(part.id, part.T_world_camera);
  require(part.cloud.colours.size() == part.cloud.size(), part.id, "every point needs a colour");
  require(part.cloud.normals.empty() || part.cloud.normals.size() == part.cloud.size(), part.id,
          "normals must be absent or one for each point");
}

/// Appends a cloud; normals are NaN where one of the two had none.
void append(ColouredCloud& target, const ColouredCloud& source) {
  const Eigen::Vector3f unknown = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  if (target.normals.empty() && !source.normals.empty()) target.normals.assign(target.size(), unknown);
  target.points.insert(target.points.end(), source.points.begin(), source.points.end());
  target.colours.insert(target.colours.end(), source.colours.begin(), source.colours.end());
  target.normals.insert(target.normals.end(), source.normals.begin(), source.normals.end());
  if (!target.normals.empty()) target.normals.resize(target.size(), unknown);
}

std::size_t bytes(const ColouredCloud& cloud) {
  return cloud.points.capacity() * sizeof cloud.points[0] +
         cloud.colours.capacity() * sizeof cloud.colours[0] +
         cloud.normals.capacity() * sizeof cloud.normals[0];
}

}  // namespace

std::size_t DenseMap::points_of(std::int32_t id) const {
  const auto keyframe = keyframes_.find(id);
  return keyframe != keyframes_.end() ? keyframe->second.cloud.size() : 0;
}

void DenseMap::check_limits(const DenseKeyframe& part) const {
  require(keyframes_.count(part.id) > 0 || keyframes_.size() < limits_.keyframes, part.id,
          "the map has as many keyframes as it may, " + std::to_string(limits_.keyframes));
  std::size_t points = points_ - points_of(part.id) + part.cloud.size();
  const auto pending = pending_.find(part.id);
  if (pending != pending_.end())
    for (const auto& [tile, cloud] : pending->second.clouds) points += cloud.size();
  require(points <= limits_.points, part.id,
          "the map has as many points as it may, " + std::to_string(limits_.points));
}

DenseMap::Pending& DenseMap::pending_for(const KeyframeTile& tile) {
  const DenseKeyframe& part = tile.part;
  const auto tiles = static_cast<std::size_t>(tile.tiles);
  if (pending_.count(part.id) == 0 && pending_.size() >= std::max<std::size_t>(1, limits_.incomplete)) {
    pending_.erase(std::min_element(pending_.begin(), pending_.end(), [](const auto& a, const auto& b) {
      return a.second.begun < b.second.begun;
    }));
    ++given_up_;
  }
  Pending& pending = pending_[part.id];
  if (pending.tiles != tiles || pending.utime != part.utime || pending.revision != part.revision) {
    pending = Pending{};
    pending.begun = ++begun_;
  }
  return pending;
}

bool DenseMap::add(const KeyframeTile& tile) {
  check(tile);
  const DenseKeyframe& part = tile.part;
  check_limits(part);
  Pending& pending = pending_for(tile);
  const auto tiles = static_cast<std::size_t>(tile.tiles);
  pending.utime = part.utime;
  pending.revision = part.revision;
  pending.tiles = tiles;
  pending.T_world_camera = part.T_world_camera;
  pending.clouds[tile.tile] = part.cloud;
  pending.clouds[tile.tile].sigmas.clear();
  if (pending.clouds.size() < tiles) return false;

  DenseKeyframe complete{part.id, pending.utime, pending.T_world_camera, {}, pending.revision};
  std::size_t points = 0;
  for (const auto& [index, cloud] : pending.clouds) points += cloud.size();
  complete.cloud.points.reserve(points);
  complete.cloud.colours.reserve(points);
  for (const auto& [index, cloud] : pending.clouds) append(complete.cloud, cloud);
  pending_.erase(part.id);
  points_ += points - points_of(complete.id);
  keyframes_[complete.id] = std::move(complete);
  ++revision_;
  return true;
}

std::vector<std::int32_t> DenseMap::correct(const std::vector<KeyframePose>& poses) {
  for (const KeyframePose& pose : poses) check_pose(pose.id, pose.T_world_camera);
  std::vector<std::int32_t> unknown;
  for (const KeyframePose& pose : poses) {
    const auto keyframe = keyframes_.find(pose.id);
    const auto pending = pending_.find(pose.id);
    if (keyframe != keyframes_.end()) keyframe->second.T_world_camera = pose.T_world_camera;
    if (pending != pending_.end()) pending->second.T_world_camera = pose.T_world_camera;
    if (keyframe == keyframes_.end() && pending == pending_.end()) unknown.push_back(pose.id);
  }
  if (unknown.size() < poses.size()) ++revision_;
  return unknown;
}

void DenseMap::follow(const std::vector<KeyframePose>& graph) {
  correct(graph);
  std::set<std::int32_t> named;
  for (const KeyframePose& pose : graph) named.insert(pose.id);
  for (auto keyframe = keyframes_.begin(); keyframe != keyframes_.end();) {
    const std::int32_t id = (keyframe++)->first;
    if (named.count(id) == 0) remove(id);
  }
}

void DenseMap::remove(std::int32_t id) {
  pending_.erase(id);
  points_ -= points_of(id);
  if (keyframes_.erase(id) > 0) ++revision_;
}

void DenseMap::clear() {
  pending_.clear();
  keyframes_.clear();
  points_ = 0;
  ++revision_;
}

ColouredCloud DenseMap::merge(double resolution) const {
  if (resolution == 0) return merge_all();
  VoxelAverage average(resolution);
  for (const auto& [id, keyframe] : keyframes_) average.add(keyframe.cloud, keyframe.T_world_camera);
  return average.result();
}

ColouredCloud DenseMap::merge_all() const {
  ColouredCloud all;
  for (const auto& [id, keyframe] : keyframes_) {
    ColouredCloud moved = keyframe.cloud;
    const Eigen::Isometry3d& T_world_camera = keyframe.T_world_camera;
    for (Eigen::Vector3f& point : moved.points) point = (T_world_camera * point.cast<double>()).cast<float>();
    for (Eigen::Vector3f& normal : moved.normals)
      normal = (T_world_camera.linear() * normal.cast<double>()).cast<float>();
    append(all, moved);
  }
  return all;
}

std::vector<std::int32_t> DenseMap::incomplete() const {
  std::vector<std::int32_t> ids;
  for (const auto& [id, pending] : pending_) {
    const auto keyframe = keyframes_.find(id);
    const bool only_repeated = keyframe != keyframes_.end() && keyframe->second.utime == pending.utime &&
                               keyframe->second.revision == pending.revision;
    if (!only_repeated) ids.push_back(id);
  }
  return ids;
}

std::size_t DenseMap::memory_bytes() const {
  std::size_t total = 0;
  for (const auto& [id, keyframe] : keyframes_) total += bytes(keyframe.cloud);
  for (const auto& [id, pending] : pending_)
    for (const auto& [index, cloud] : pending.clouds) total += bytes(cloud);
  return total;
}

}  // namespace lcmslam
