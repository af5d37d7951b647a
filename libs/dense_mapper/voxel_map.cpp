#include <lcmslam/dense_mapper/voxel_map.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <lcmslam/dense_mapper/by_node.hpp>
#include <lcmslam/registration/tangent_gradient.hpp>
#include <lcmslam/settings/check.hpp>

namespace lcmslam {
namespace {

constexpr int block_side = 4;  // voxels
constexpr float smallest_sigma = 1e-4f;
constexpr float same_surface = 0.7f;  // cosine
constexpr float owner_within = 0.1f;  // m
constexpr float place_side = 0.02f;   // m, of a PlaceInView

Eigen::Vector3i block_of(const Eigen::Vector3i& voxel) {
  return {voxel.x() >> 2, voxel.y() >> 2, voxel.z() >> 2};
}

std::int8_t cell_of(const Eigen::Vector3i& voxel) {
  constexpr int mask = block_side - 1;
  return static_cast<std::int8_t>((voxel.x() & mask) | (voxel.y() & mask) << 2 | (voxel.z() & mask) << 4);
}

// So far that it is no other part of the same voxel.
bool has_passed(const std::array<std::uint8_t, 3>& a, const std::array<std::uint8_t, 3>& b) {
  constexpr float far_enough = 0.1f;  // m
  int squared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const int difference = static_cast<std::int8_t>(a[i] - b[i]);
    squared += difference * difference;
  }
  return static_cast<float>(squared) * place_side * place_side >= far_enough * far_enough;
}

}  // namespace

VoxelMap::VoxelMap(const VoxelMapSettings& settings)
    : settings_(settings), inverse_size_(static_cast<float>(1.0 / settings.voxel_size)) {
  check(settings, "voxel map");
}

VoxelMap::Block& VoxelMap::block_at(const Eigen::Vector3i& position) {
  const auto next = static_cast<std::int32_t>(blocks_.size());
  const std::int32_t slot = index_.insert(voxel_key(position), next);
  if (slot == next) blocks_.push_back({position, -1, {}});
  return blocks_[static_cast<std::size_t>(slot)];
}

VoxelMap::PlaceInView VoxelMap::place_in_view(const Eigen::Vector3f& point) {
  PlaceInView place;
  for (int i = 0; i < 3; ++i)
    place[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(static_cast<int>(std::floor(point[i] / place_side)) & 255);
  return place;
}

void VoxelMap::insert(const Cloud& cloud, const Eigen::Isometry3d& T_map_view, int anchor) {
  ++frame_;
  if (!cloud.has_normals()) return;
  insertions_.push_back(frame_);
  if (insertions_.size() > static_cast<std::size_t>(settings_.min_observations)) insertions_.pop_front();
  recent_from_ = insertions_.front();
  intensities_ = intensities_ || !cloud.intensities.empty();
  const Eigen::Isometry3f T_view_map = T_map_view.inverse().cast<float>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!voxel_exists(cloud.points[i], inverse_size_) || !cloud.normals[i].allFinite()) continue;
    float sigma = cloud.sigmas.empty() ? 0.01f : cloud.sigmas[i];
    if (!std::isfinite(sigma)) continue;
    sigma = std::max(sigma, smallest_sigma);
    const float intensity = cloud.intensities.empty() ? TargetPoint::unknown : cloud.intensities[i];
    merge({cloud.points[i], cloud.normals[i], 1.0f / (sigma * sigma), sigma, intensity, 1, 0, 1, frame_,
           anchor, place_in_view(T_view_map * cloud.points[i])});
  }
  if (blocks_.size() > static_cast<std::size_t>(settings_.max_blocks)) forget(T_map_view.translation());
}

// Into the surfel of its voxel that faces the same way, or beside it.
void VoxelMap::merge(const Surfel& seen) {
  const Eigen::Vector3i voxel = voxel_of(seen.point, inverse_size_);
  const std::int8_t cell = cell_of(voxel);
  Block& block = block_at(block_of(voxel));
  const auto agreement = static_cast<float>(settings_.normal_agreement);
  for (Surfel& s : block.surfels) {
    if (s.cell != cell || s.normal.dot(seen.normal) < agreement) continue;
    const float one = 1.0f / (seen.sigma * seen.sigma);  // weight of one observation
    const float share = seen.weight / (s.weight + seen.weight);
    s.point += share * (seen.point - s.point);
    const Eigen::Vector3f blended = s.normal + share * (seen.normal - s.normal);
    if (const float length = blended.norm(); length > 0.1f) s.normal = blended / length;
    s.sigma += share * (seen.sigma - s.sigma);
    if (std::isnan(s.intensity)) s.intensity = seen.intensity;
    if (!std::isnan(seen.intensity)) s.intensity += share * (seen.intensity - s.intensity);
    s.weight = std::min(s.weight + seen.weight, static_cast<float>(settings_.max_weight) * one);
    if (s.frame != seen.frame) {
      s.observations = static_cast<std::int16_t>(std::min<int>(s.observations + seen.observations, 32767));
      s.evidence = static_cast<std::int8_t>(
          std::clamp(s.evidence + seen.evidence, settings_.dropped_at + 1, settings_.max_evidence));
    }
    s.frame = std::max(s.frame, seen.frame);
    s.passed = s.passed || seen.passed || has_passed(s.first_seen, seen.first_seen);
    return;
  }
  block.surfels.push_back(seen);
  block.surfels.back().cell = cell;
  ++surfels_;
}

void VoxelMap::renumber_anchors(const std::vector<int>& number) {
  for (Block& block : blocks_)
    for (Surfel& s : block.surfels) s.anchor = of_node(number, s.anchor);
}

VoxelMap VoxelMap::deformed(const std::vector<Eigen::Isometry3d>& T_new_old) const {
  VoxelMap map(settings_);
  map.frame_ = frame_ + 1;
  map.forgotten_ = forgotten_;
  map.intensities_ = intensities_;
  map.insertions_ = insertions_;
  map.recent_from_ = recent_from_;
  map.index_.clear(blocks_.size());
  map.blocks_.reserve(blocks_.size());
  std::vector<Eigen::Isometry3f> moves;
  moves.reserve(T_new_old.size());
  for (const Eigen::Isometry3d& T : T_new_old) moves.push_back(T.cast<float>());
  for (const Block& block : blocks_)
    for (Surfel s : block.surfels) {
      if (!moves.empty()) {
        const Eigen::Isometry3f& T = of_node(moves, s.anchor);
        s.point = T * s.point;
        s.normal = T.linear() * s.normal;
      }
      if (voxel_exists(s.point, inverse_size_)) map.merge(s);
    }
  return map;
}

bool VoxelMap::find(const Eigen::Vector3f& point, float max_distance, TargetPoint& found) const {
  float others = 0;
  return find_nearest(point, max_distance, found, others);
}

bool VoxelMap::find_nearest(const Eigen::Vector3f& point, float max_distance, TargetPoint& found,
                            float& others) const {
  others = 0;
  if (!(max_distance >= 0) || !voxel_exists(point.cwiseAbs().array() + max_distance, inverse_size_))
    return false;
  float best = max_distance * max_distance;
  float next = std::numeric_limits<float>::infinity();  // squared: nothing else is nearer
  const Surfel* nearest = nullptr;
  const Block* home = nullptr;
  const auto search = [&](const Eigen::Vector3i& block) {
    const std::int32_t slot = index_.find(voxel_key(block));
    if (slot == VoxelIndex::none) return;
    const Block& candidates = blocks_[static_cast<std::size_t>(slot)];
    for (const Surfel& s : candidates.surfels) {
      const float d = (s.point - point).squaredNorm();
      if (d > best) {
        next = std::min(next, d);
        continue;
      }
      if (!is_partner(s)) continue;
      if (nearest) next = std::min(next, best);
      best = d;
      nearest = &s;
      home = &candidates;
    }
  };
  // The point's own block first: mostly the others are then too far away to hold anything nearer.
  const Eigen::Vector3i own = block_of(voxel_of(point, inverse_size_));
  search(own);
  const Eigen::Vector3f reach = Eigen::Vector3f::Constant(1.0001f * std::sqrt(best));  // for rounding
  const Eigen::Vector3i low = block_of(voxel_of(point - reach, inverse_size_));
  const Eigen::Vector3i high = block_of(voxel_of(point + reach, inverse_size_));
  const float side = block_side / inverse_size_;
  for (int x = low.x(); x <= high.x(); ++x)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int z = low.z(); z <= high.z(); ++z) {
        const Eigen::Vector3i block(x, y, z);
        if (block == own) continue;
        const Eigen::Array3f corner = side * block.cast<float>().array();
        const Eigen::Array3f outside = (corner - point.array()).max(point.array() - corner - side).max(0.0f);
        const float away = outside.square().sum();
        if (away <= best)
          search(block);
        else
          next = std::min(next, away);
      }
  const Eigen::Array3f to_rim = (point.array() - side * low.cast<float>().array())
                                    .min(side * (high.array() + 1).cast<float>() - point.array());
  others = std::min(std::sqrt(next), to_rim.minCoeff());
  if (!nearest) return false;
  found = {nearest->point, nearest->normal, sigma_of_mean(*nearest), nearest->intensity};
  found.young = is_young(*nearest);
  if (!std::isnan(nearest->intensity)) found.gradient = gradient_at(*nearest, *home);
  return true;
}

// Once it remembers n = max_weight observations each new one has a share of a = 1 / (n + 1), and the variance
// v of the mean settles where v = (1 - a)^2 v + a^2 sigma^2: at that of 2 n + 1 observations.
float VoxelMap::sigma_of_mean(const Surfel& surfel) const {
  const float most = 2 * static_cast<float>(settings_.max_weight) + 1;
  return surfel.sigma / std::sqrt(std::min(static_cast<float>(surfel.observations), most));
}

// From the surface around it within its block.
Eigen::Vector3f VoxelMap::gradient_at(const Surfel& surfel, const Block& block) const {
  TangentGradient gradient(surfel.normal);
  for (const Surfel& s : block.surfels)
    if (!std::isnan(s.intensity) && s.normal.dot(surfel.normal) > same_surface)
      gradient.add(s.point - surfel.point, s.intensity - surfel.intensity);
  return gradient.solve();
}

std::vector<int> VoxelMap::owners(const Cloud& cloud, std::size_t asked) const {
  std::vector<int> owners;
  TargetPoint found;
  const std::size_t step = 1 + cloud.size() / std::max<std::size_t>(1, asked);
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    if (!find(cloud.points[i], owner_within, found)) continue;
    if (cloud.has_normals() && !(found.normal.dot(cloud.normals[i]) > same_surface)) continue;
    const std::int32_t slot = index_.find(voxel_key(block_of(voxel_of(found.point, inverse_size_))));
    if (slot == VoxelIndex::none) continue;
    const std::vector<Surfel>& surfels = blocks_[static_cast<std::size_t>(slot)].surfels;
    const auto surfel = std::find_if(surfels.begin(), surfels.end(), [&](const Surfel& s) {
      return s.point == found.point && s.normal == found.normal;
    });
    if (surfel == surfels.end()) continue;
    const auto owner = static_cast<std::size_t>(std::max(0, surfel->anchor));
    if (owners.size() <= owner) owners.resize(owner + 1, 0);
    ++owners[owner];
  }
  return owners;
}

std::size_t VoxelMap::memory_bytes() const {
  std::size_t bytes = blocks_.capacity() * sizeof(Block) + index_.memory_bytes();
  for (const Block& block : blocks_) bytes += block.surfels.capacity() * sizeof(Surfel);
  return bytes;
}

// Drops a tenth, so that this happens rarely: first what holds nothing any more, then what is farthest.
void VoxelMap::forget(const Eigen::Vector3d& view_point) {
  const double block_size = settings_.voxel_size * block_side;
  std::vector<double> distance(blocks_.size());
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    distance[i] =
        ((blocks_[i].position.cast<double>().array() + 0.5).matrix() * block_size - view_point).norm();
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    if (!blocks_[i].surfels.empty()) order.push_back(i);
  const auto left = static_cast<std::size_t>(0.9 * settings_.max_blocks);
  forgotten_ = forgotten_ || order.size() > left;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return distance[a] < distance[b]; });
  if (order.size() > left) order.resize(left);
  std::sort(order.begin(), order.end());

  std::vector<Block> kept;
  kept.reserve(order.size());
  index_.clear(order.size());
  surfels_ = 0;
  for (const std::size_t i : order) {
    index_.insert(voxel_key(blocks_[i].position), static_cast<std::int32_t>(kept.size()));
    surfels_ += blocks_[i].surfels.size();
    kept.push_back(std::move(blocks_[i]));
  }
  blocks_ = std::move(kept);
}

void VoxelMap::append(const Surfel& s, Cloud& cloud) const {
  cloud.points.push_back(s.point);
  cloud.normals.push_back(s.normal);
  cloud.sigmas.push_back(sigma_of_mean(s));
  if (intensities_) cloud.intensities.push_back(s.intensity);
}

Cloud VoxelMap::cloud() const {
  Cloud cloud;
  for (const Block& block : blocks_)
    for (const Surfel& s : block.surfels) append(s, cloud);
  return cloud;
}

Cloud VoxelMap::partners_around(const Eigen::Vector3d& centre, double radius) const {
  Cloud cloud;
  const Eigen::Vector3f c = centre.cast<float>();
  const auto squared_radius = static_cast<float>(radius * radius);
  const float side = block_side / inverse_size_;
  const float reach = static_cast<float>(radius) + side;  // half a block's diagonal is 0.87 sides
  for (const Block& block : blocks_) {
    const Eigen::Vector3f middle = side * (block.position.cast<float>().array() + 0.5f).matrix();
    if ((middle - c).squaredNorm() > reach * reach) continue;
    for (const Surfel& s : block.surfels)
      if (is_partner(s) && (s.point - c).squaredNorm() <= squared_radius) append(s, cloud);
  }
  return cloud;
}

}  // namespace lcmslam
