#include <lcmslam/map_layers/distance_field.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <lcmslam/settings/check.hpp>

namespace lcmslam {

DistanceField::DistanceField(double cell_size, const DistanceSettings& settings)
    : cell_size_(cell_size),
      truncation_(settings.truncation),
      reach_(static_cast<int>(settings.truncation / cell_size + 1e-6)) {
  check(settings, "distance");
  if (!(cell_size > 0) || reach_ < least_reach || reach_ > greatest_reach)
    throw std::invalid_argument("distance.truncation: " + number_text(truncation_) + " m of cells of " +
                                number_text(cell_size) + " m; must be 2 to 100 cells");
}

void DistanceField::update(const std::vector<OccupancyChange>& changes) {
  Blocks changed;
  for (const OccupancyChange& change : changes) {
    changed.push_back(change.block);
    occupied_.erase(change.block);
    if (std::all_of(change.occupied.begin(), change.occupied.end(), [](auto bits) { return bits == 0; }))
      continue;
    auto cells = std::make_unique<SquaredDistances>();
    for (std::size_t i = 0; i < cells->size(); ++i)
      (*cells)[i] = (change.occupied[i / 64] >> (i % 64) & 1) != 0 ? std::int16_t{0} : far_squared;
    occupied_.make(change.block) = std::move(cells);
  }
  changed = pass(changed, 2, occupied_, along_z_);
  changed = pass(changed, 1, along_z_, along_zy_);
  pass(changed, 0, along_zy_, along_zyx_);
}

DistanceField::Blocks DistanceField::reached_by(const Blocks& changed, int axis) const {
  const int blocks = (reach_ + block_side - 1) / block_side;
  VoxelIndex known(changed.size());
  Blocks reached;
  for (const Eigen::Vector3i& block : changed)
    for (int k = -blocks; k <= blocks; ++k) {
      const Eigen::Vector3i other = block + k * Eigen::Vector3i::Unit(axis);
      const auto next = static_cast<std::int32_t>(reached.size());
      if (known.insert(voxel_key(other), next) == next) reached.push_back(other);
    }
  return reached;
}

// Those blocks of `to` that are others than before.
DistanceField::Blocks DistanceField::pass(const Blocks& changed, int axis, const DistanceLayer& from,
                                          DistanceLayer& to) const {
  Blocks differing;
  SquaredDistances now;
  for (const Eigen::Vector3i& block : reached_by(changed, axis)) {
    const bool near = transform_block(from, block, axis, reach_, now);
    const auto* before = to.find(block);
    if (near ? before != nullptr && **before == now : before == nullptr) continue;
    differing.push_back(block);
    if (near)
      to.make(block) = std::make_unique<SquaredDistances>(now);
    else
      to.erase(block);
  }
  return differing;
}

double DistanceField::cell_distance(const Eigen::Vector3f& point) const {
  const auto inverse_size = static_cast<float>(1 / cell_size_);
  if (!voxel_exists(point, inverse_size)) return truncation_;
  const Eigen::Vector3i cell = voxel_of(point, inverse_size);
  const auto* block = along_zyx_.find(block_of(cell));
  if (block == nullptr) return truncation_;
  const std::int16_t square = (**block)[static_cast<std::size_t>(place_in_block(cell))];
  return square == far_squared ? truncation_ : cell_size_ * std::sqrt(static_cast<double>(square));
}

DistanceField::Sample DistanceField::sample(const Eigen::Vector3d& point) const {
  if (!voxel_exists(point.cast<float>(), static_cast<float>(1 / cell_size_)))
    return {truncation_, Eigen::Vector3d::Zero()};
  const Eigen::Vector3d at = (point.array() / cell_size_ - 0.5).matrix();
  const Eigen::Vector3d low = at.array().floor();
  const Eigen::Vector3d share = at - low;
  Sample sample{0, Eigen::Vector3d::Zero()};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i upper(corner & 1, corner >> 1 & 1, corner >> 2);
    const Eigen::Vector3d centre = ((low + upper.cast<double>()).array() + 0.5) * cell_size_;
    const double distance = cell_distance(centre.cast<float>());
    Eigen::Vector3d weight, slope;
    for (int axis = 0; axis < 3; ++axis) {
      weight[axis] = upper[axis] != 0 ? share[axis] : 1 - share[axis];
      slope[axis] = (upper[axis] != 0 ? 1 : -1) / cell_size_;
    }
    sample.distance += weight.prod() * distance;
    sample.gradient +=
        distance * Eigen::Vector3d(slope.x() * weight.y() * weight.z(), slope.y() * weight.x() * weight.z(),
                                   slope.z() * weight.x() * weight.y());
  }
  return sample;
}

std::size_t DistanceField::memory_bytes() const {
  std::size_t bytes = 0;
  for (const DistanceLayer* layer : {&occupied_, &along_z_, &along_zy_, &along_zyx_})
    bytes += layer->memory_bytes() + layer->size() * (sizeof(SquaredDistances) + 16);  // 16: of the allocator
  return bytes;
}

}  // namespace lcmslam
