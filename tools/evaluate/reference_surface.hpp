#pragma once
// The surfaces that a log's depth images show when they are put at known poses: what a map is measured
// against where there is no scene to compare with.

#include <string>

#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/evaluation/trajectory.hpp>

namespace lcmslam {

class ReferenceSurface {
 public:
  /// Fuses the images of `log` that lie on the path: of the robot, or of its colour camera. `clock_offset`:
  /// s, added to the images' stamps gives the truth's clock. Throws std::runtime_error when there are none,
  /// or no calibration.
  ReferenceSurface(const std::string& log, const Trajectory& truth, bool of_camera, double clock_offset);

  /// m from the tangent plane of the nearest fused point, or from that point where it lies farther beside;
  /// the reach where nothing is nearer.
  float distance(const Eigen::Vector3f& point, float reach) const;

  int frames() const { return frames_; }
  int refused() const { return refused_; }  ///< messages that could not be decoded
  std::size_t points() const { return map_.size(); }

 private:
  VoxelMap map_;
  int frames_ = 0, refused_ = 0;
};

}  // namespace lcmslam
