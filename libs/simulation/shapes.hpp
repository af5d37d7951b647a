#pragma once
// Triangles of boxes, cylinders, panels and meshes.

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include <lcmslam/simulation/scene.hpp>

namespace lcmslam {

/// What a face is covered with.
struct FaceMaterial {
  std::uint16_t index = 0;                                 ///< into Scene::materials
  bool fitted = false;                                     ///< stretch one repetition over each face
  Eigen::Vector2f texture_size = Eigen::Vector2f::Ones();  ///< m, of one repetition
};

class ShapeBuilder {
 public:
  explicit ShapeBuilder(std::vector<SceneTriangle>& triangles) : triangles_(triangles) {}

  SurfaceKind kind = SurfaceKind::object;

  /// Parallelogram seen from its front, upright: corner is upper left, `right` and `down` its edges (m).
  void quad(const Eigen::Vector3f& corner, const Eigen::Vector3f& right, const Eigen::Vector3f& down,
            const FaceMaterial& material);

  /// Box in its own frame: x and y centred, z from 0. Faces: front (+x), left (+y), back, right, top, bottom.
  void box(const Eigen::Isometry3f& T_world_box, const Eigen::Vector3f& size,
           const std::array<FaceMaterial, 6>& faces);

  /// Cone frustum about z, from z = 0, with or without lids, smooth side.
  void cylinder(const Eigen::Isometry3f& T_world_cylinder, float radius, float top_radius, float height,
                bool lids, const FaceMaterial& side, const FaceMaterial& lid);

  /// Corner indices by threes, counter-clockwise from outside; texture projected along the largest
  /// component of each triangle's normal.
  void mesh(const Eigen::Isometry3f& T_world_mesh, const std::vector<Eigen::Vector3f>& vertices,
            const std::vector<int>& indices, const FaceMaterial& material);

 private:
  std::vector<SceneTriangle>& triangles_;
};

}  // namespace lcmslam
