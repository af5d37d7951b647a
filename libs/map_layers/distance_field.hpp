#pragma once
// How far the nearest occupied cell is, everywhere: exact Euclidean distances between the cells' centres up
// to a truncation. Three passes along the axes; a change of the grid is followed through each pass only as
// far as something changes, so that an update costs what the change touches.
//
// The field owns all it needs: it may live in a thread of its own, fed with OccupancyGrid::take_changes().
// Beyond the truncation nothing is stored; inside, 3 kB a block.

#include <vector>

#include <lcmslam/map_layers/distance_layer.hpp>
#include <lcmslam/map_layers/occupancy_grid.hpp>

namespace lcmslam {

struct DistanceSettings {
  double truncation = 2;
  double memory = 200;

  void describe(SettingsVisitor& s) {
    s.number("truncation", truncation, "m", {0.05, 10},
             "distance beyond which nothing is told apart; 2 to 100 cells");
    s.number("memory", memory, "MB", {1, 100'000},
             "of the distances that are kept, those around the robot; elsewhere they are made when they are "
             "asked for");
  }
};

class DistanceField {
 public:
  /// Throws std::invalid_argument that names the setting.
  explicit DistanceField(double cell_size, const DistanceSettings& settings = {});

  /// Each change holds all that is occupied in its block from now on.
  void update(const std::vector<OccupancyChange>& changes);

  double cell_size() const { return cell_size_; }
  double truncation() const { return truncation_; }

  /// m between the centre of the point's cell and that of the nearest occupied cell; truncation() where that
  /// is farther, or the point not finite.
  double cell_distance(const Eigen::Vector3f& point) const;

  struct Sample {
    double distance;           ///< m from the point to the nearest occupied cell's centre, interpolated
    Eigen::Vector3d gradient;  ///< of the distance; zero beyond the truncation
  };
  /// Trilinear between the cells' centres, so continuous; the gradient is that of the interpolation.
  Sample sample(const Eigen::Vector3d& point) const;

  std::size_t occupied_blocks() const { return occupied_.size(); }
  std::size_t memory_bytes() const;

 private:
  using Blocks = std::vector<Eigen::Vector3i>;
  Blocks reached_by(const Blocks& changed, int axis) const;
  Blocks pass(const Blocks& changed, int axis, const DistanceLayer& from, DistanceLayer& to) const;

  double cell_size_, truncation_;
  int reach_;  // cells
  DistanceLayer occupied_, along_z_, along_zy_, along_zyx_;
};

}  // namespace lcmslam
