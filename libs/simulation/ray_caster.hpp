#pragma once
// Rays against the scene's triangles (Embree).

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include <lcmslam/simulation/scene.hpp>

namespace lcmslam {

/// Eight rays from one point. Directions need not be unit vectors; `range` counts their lengths.
struct RayPacket {
  static constexpr int size = 8;
  static constexpr unsigned none = ~0u;
  alignas(32) float x[size], y[size], z[size];
  alignas(32) float range[size];
  alignas(32) float u[size], v[size];   ///< barycentric weights of corners 1 and 2
  alignas(32) unsigned triangle[size];  ///< index into Scene::triangles, or none

  /// Directions of the pixels of an image row from column `first` on, the last one again beyond its end.
  /// `row` holds x/z and y/z of each pixel's ray in the camera frame.
  void aim(const cv::Vec2f* row, int first, int width, const Eigen::Matrix3f& R_world_camera);
};

class RayCaster {
 public:
  explicit RayCaster(const Scene& scene);
  ~RayCaster();

  /// Fills range, u, v and triangle with the nearest hits. May be called by several threads.
  void cast(const Eigen::Vector3f& origin, RayPacket& rays) const;

  /// Distance along one ray (in lengths of `direction`), infinity when it hits nothing.
  float cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;

  /// Distance in metres from a point to the nearest surface.
  double distance(const Eigen::Vector3d& point) const;

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace lcmslam
