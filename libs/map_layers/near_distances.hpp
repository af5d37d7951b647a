#pragma once
// Distances around the robot, as far as memory bears: of a large map the field is kept in a ball that goes
// with the robot. Elsewhere distances are made of the occupied blocks when somebody asks (field_of()).

#include <Eigen/Geometry>
#include <limits>
#include <optional>

#include <lcmslam/map_layers/distance_field.hpp>

namespace lcmslam {

class NearDistances {
 public:
  /// `sight`: m from the robot to the farthest that a frame shows. Throws std::invalid_argument that names
  /// the setting.
  NearDistances(double cell_size, const DistanceSettings& settings, double sight);

  /// As DistanceField::update(); what lies outside the ball is left out.
  void update(const std::vector<OccupancyChange>& changes);

  const DistanceField& field() const { return field_; }
  /// Whether the field's distances hold in all of the box, m.
  bool covers(const Eigen::AlignedBox3d& box) const;

  /// Around the robot's place anew, of the grid that all changes came from; nothing when there is no need:
  /// the robot is far from the ball's rim, and the field no larger than its bound.
  std::optional<NearDistances> moved(const Eigen::Vector3d& place, const OccupancyGrid& grid) const;

  std::size_t memory_bytes() const { return field_.memory_bytes(); }

 private:
  bool is_inside(const Eigen::Vector3i& block) const;
  double distance_to(const Eigen::Vector3i& block) const;

  DistanceSettings settings_;
  double margin_;  // m from the rim inside which the robot must stay: sight and truncation
  double block_size_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = std::numeric_limits<double>::infinity();  // m; at first all of the map fits
  DistanceField field_;
};

/// What is occupied within the truncation of the box, for field_of().
std::vector<OccupancyChange> occupied_around(const Eigen::AlignedBox3d& box, double truncation,
                                             const OccupancyGrid& grid);
/// Distances that hold where occupied_around() looked.
DistanceField field_of(const std::vector<OccupancyChange>& occupied, double cell_size,
                       const DistanceSettings& settings);

}  // namespace lcmslam
