#pragma once
// Which points of a map a picture shows, and which count for its extent.

#include <vector>

#include <lcmslam/rendering/map_picture.hpp>
#include <lcmslam/rendering/splat.hpp>
#include <lcmslam/rendering/view_camera.hpp>

namespace lcmslam {

/// Whether it is known: files have 0 0 0 where it is not (save_ply()).
bool has_normal(const ColouredCloud& cloud, std::size_t i);

class PicturePoints {
 public:
  /// Keeps a reference to the request.
  explicit PicturePoints(const PictureRequest& request);

  /// No cloud point, landmark or path.
  bool empty() const { return nothing_; }

  /// A sample of cloud points (those visible to the camera, when given), landmarks and paths.
  std::vector<Eigen::Vector3d> extent(const ViewCamera* camera) const;

  /// Cloud points on surfaces that face the viewer and are not cut away.
  std::vector<SplatPoint> visible(const ViewCamera& camera) const;

 private:
  bool shown(const ColouredCloud& cloud, std::size_t i, const ViewCamera& camera, double nearest) const;
  void add(const ColouredCloud& cloud, const std::vector<std::size_t>& candidates, const ViewCamera& camera,
           bool paint, std::vector<SplatPoint>& splats) const;
  /// Depth before which points without normal are cut away in the front view.
  double nearest_depth(const ViewCamera& camera) const;

  const PictureRequest& request_;
  std::vector<std::size_t> candidates_;  ///< finite cloud points below the cut
  std::size_t without_normal_ = 0;       ///< how many of them
  bool nothing_ = true;
};

}  // namespace lcmslam
