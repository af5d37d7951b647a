#include <lcmslam/map_layers/near_distances.hpp>

#include <algorithm>

namespace lcmslam {
namespace {

constexpr double filled = 0.5;  // of the bound, when the ball is chosen: the map grows in it

OccupancyChange occupied_in(const Eigen::Vector3i& block, const OccupancyGrid& grid) {
  OccupancyChange change{block, {}};
  BlockLogOdds cells;
  grid.load(block, cells);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i] > 0) change.occupied[i / 64] |= std::uint64_t{1} << (i % 64);
  return change;
}

bool has_occupied(const OccupancyChange& change) {
  return std::any_of(change.occupied.begin(), change.occupied.end(), [](auto bits) { return bits != 0; });
}

/// A block whose cells all say that they are not occupied needs no look at each.
bool may_be_occupied(const Eigen::Vector3i& block, const OccupancyGrid& grid) {
  const auto all = grid.uniform(block);
  return !all || *all > 0;
}

}  // namespace

NearDistances::NearDistances(double cell_size, const DistanceSettings& settings, double sight)
    : settings_(settings),
      margin_(sight + settings.truncation),
      block_size_(block_side * cell_size),
      field_(cell_size, settings) {}

double NearDistances::distance_to(const Eigen::Vector3i& block) const {
  return (((block.cast<double>().array() + 0.5) * block_size_).matrix() - centre_).norm();
}

/// The block's corners too, so that a box that is covered has all its obstacles.
bool NearDistances::is_inside(const Eigen::Vector3i& block) const {
  return distance_to(block) <= radius_ + block_size_;
}

void NearDistances::update(const std::vector<OccupancyChange>& changes) {
  std::vector<OccupancyChange> inside;
  for (const OccupancyChange& change : changes)
    if (is_inside(change.block)) inside.push_back(change);
  field_.update(inside);
}

bool NearDistances::covers(const Eigen::AlignedBox3d& box) const {
  const Eigen::Vector3d corner = (box.min() - centre_).cwiseAbs().cwiseMax((box.max() - centre_).cwiseAbs());
  return corner.norm() + settings_.truncation <= radius_;
}

std::optional<NearDistances> NearDistances::moved(const Eigen::Vector3d& place,
                                                  const OccupancyGrid& grid) const {
  const double most = 1e6 * settings_.memory;
  const auto now = static_cast<double>(field_.memory_bytes());
  const bool far_from_rim = (place - centre_).norm() + margin_ <= radius_;
  // A ball that cannot be smaller stays, however much it holds.
  const bool smallest = radius_ <= 1.5 * margin_;
  if (far_from_rim && (now <= most || smallest)) return std::nullopt;

  NearDistances other(field_.cell_size(), settings_, margin_ - settings_.truncation);
  other.centre_ = place;
  std::vector<std::pair<double, Eigen::Vector3i>> blocks;  // m away, occupied ones
  for (const Eigen::Vector3i& block : grid.blocks())
    if (may_be_occupied(block, grid)) blocks.emplace_back(other.distance_to(block), block);
  // Memory goes with the occupied blocks, as it does now.
  const double each =
      std::max(now / static_cast<double>(std::max<std::size_t>(field_.occupied_blocks(), 1)), 1.0);
  const auto bearable = static_cast<std::size_t>(filled * most / each);
  if (bearable < blocks.size()) {
    const auto last = blocks.begin() + static_cast<std::ptrdiff_t>(bearable);
    std::nth_element(blocks.begin(), last, blocks.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    other.radius_ = std::max(last->first, 1.5 * margin_);
  }
  std::vector<OccupancyChange> inside;
  for (const auto& [distance, block] : blocks)
    if (other.is_inside(block)) inside.push_back(occupied_in(block, grid));
  other.field_.update(inside);
  return other;
}

std::vector<OccupancyChange> occupied_around(const Eigen::AlignedBox3d& box, double truncation,
                                             const OccupancyGrid& grid) {
  const auto block = [&](const Eigen::Vector3d& corner) {
    return block_of(grid.cell_of(corner.cast<float>().cwiseMax(-1e5f).cwiseMin(1e5f)));
  };
  const Eigen::Vector3d reach =
      Eigen::Vector3d::Constant(truncation + 2 * static_cast<double>(grid.cell_size()));
  const Eigen::Vector3i from = block(box.min() - reach), to = block(box.max() + reach);
  std::vector<OccupancyChange> occupied;
  for (const Eigen::Vector3i& at : grid.blocks()) {
    if ((at.array() < from.array()).any() || (at.array() > to.array()).any() || !may_be_occupied(at, grid))
      continue;
    occupied.push_back(occupied_in(at, grid));
    if (!has_occupied(occupied.back())) occupied.pop_back();
  }
  return occupied;
}

DistanceField field_of(const std::vector<OccupancyChange>& occupied, double cell_size,
                       const DistanceSettings& settings) {
  DistanceField field(cell_size, settings);
  field.update(occupied);
  return field;
}

}  // namespace lcmslam
