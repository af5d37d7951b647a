#pragma once
// What the newest frame shows, as a distance field of its own: a person in the way is there before log-odds
// have made up their mind.

#include <algorithm>

#include <lcmslam/map_layers/depth_carver.hpp>
#include <lcmslam/map_layers/distance_field.hpp>

namespace lcmslam {

class NewestFrame {
 public:
  /// Shorter truncations make it quicker: it is made anew with each frame where something moves.
  explicit NewestFrame(double cell_size) : field_(cell_size, {std::max(0.5, 2 * cell_size)}) {}

  /// `hits` of DepthCarver; what the frame before showed is forgotten.
  void show(const std::vector<OccupancyChange>& hits);
  const DistanceField& field() const { return field_; }

 private:
  DistanceField field_;
  std::vector<OccupancyChange> shown_;
};

}  // namespace lcmslam
