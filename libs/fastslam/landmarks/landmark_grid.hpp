#pragma once
// Where the landmarks of one map stand, by cells of 2 m: what may be in view is found without looking at the
// landmarks of other cells; of these a test each is all that a large building costs. It follows the best
// particle's map from step to step at the cost of what changed.

#include <array>
#include <memory>
#include <vector>

#include <lcmslam/fastslam/landmarks/landmark_index.hpp>
#include <lcmslam/fastslam/landmarks/particle_map.hpp>

namespace lcmslam {

class LandmarkGrid {
 public:
  LandmarkGrid() = default;
  LandmarkGrid(const LandmarkGrid&) = delete;  // places point into cells
  LandmarkGrid& operator=(const LandmarkGrid&) = delete;
  LandmarkGrid(LandmarkGrid&&) = default;
  LandmarkGrid& operator=(LandmarkGrid&&) = default;

  struct Entry {
    int slot;
    Eigen::Vector3d mean;  ///< m, world
  };

  /// Takes over what differs from the map of the last call. Landmarks of known identity are left out.
  void follow(const ParticleMap& map, const LandmarkIndex& index);

  /// Calls visit(entry) for all in the cells for which near(centre, radius of the sphere around the cell)
  /// holds, cell by cell: always in the same order after the same calls of follow(). Some may have died
  /// since.
  template <class Near, class Visit>
  void for_each(Near near, Visit visit) const {
    const double radius = 0.5 * std::sqrt(3.) * cell_size;
    for (const auto& [key, entries] : cells_)
      if (near(cell_size * Eigen::Vector3d(key[0] + 0.5, key[1] + 0.5, key[2] + 0.5), radius))
        for (const Entry& entry : *entries) visit(entry);
  }

 private:
  static constexpr double cell_size = 2;  // m
  using Key = std::array<int, 3>;
  struct Place {
    std::vector<Entry>* cell = nullptr;  // null: nowhere
    std::size_t position = 0;
    Key key{};
  };

  static Key key_of(const Eigen::Vector3d& mean);
  void remove(std::size_t slot);
  void put(std::size_t slot, const Eigen::Vector3d& mean);

  /// The cell's entries, which stay where they are.
  std::vector<Entry>& cell(const Key& key);

  struct Cell {
    Key key;
    std::unique_ptr<std::vector<Entry>> entries;
  };
  std::vector<Cell> cells_;    // ordered by key: the same results on every machine
  std::vector<Place> places_;  // by slot
  ParticleMap followed_;
};

}  // namespace lcmslam
