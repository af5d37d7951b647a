#pragma once
// What a frame proves of landmarks that it does not show.

#include <array>
#include <vector>

#include <lcmslam/fastslam/association/image_grid.hpp>
#include <lcmslam/fastslam/association/usable_features.hpp>
#include <lcmslam/fastslam/association/visible_landmarks.hpp>

namespace lcmslam {

/// Borrows the frame.
class LandmarkVisibility {
 public:
  LandmarkVisibility(const FeatureFrame& frame, const std::vector<FeaturePoint>& points,
                     const Eigen::Isometry3d& T_world_robot);

  /// Well inside the image, and with a measured point beside it that is not in front of it.
  bool is_free(const VisibleLandmark& landmark) const;
  /// All points measured beside it are in front of it.
  bool is_hidden(const VisibleLandmark& landmark) const;
  /// Free, and seen before from about there.
  bool ought_to_show(const VisibleLandmark& landmark, const LandmarkRecord& record) const;
  std::size_t cell(const VisibleLandmark& landmark) const { return grid_.cell(landmark.x, landmark.y); }

 private:
  bool is_inside(const VisibleLandmark& landmark) const;

  const FeatureFrame& frame_;
  ImageGrid grid_;
  Eigen::Vector3d camera_;
  std::array<double, ImageGrid::cell_count> farthest_{};  // measured in each cell
};

}  // namespace lcmslam
