#include <lcmslam/simulation/shapes.hpp>

#include <cmath>

namespace lcmslam {

using Eigen::Isometry3f;
using Eigen::Vector2f;
using Eigen::Vector3f;

void ShapeBuilder::quad(const Vector3f& corner, const Vector3f& right, const Vector3f& down,
                        const FaceMaterial& material) {
  const Vector3f corners[4] = {corner, corner + right, corner + right + down, corner + down};
  const Vector2f extent = material.fitted ? material.texture_size : Vector2f(right.norm(), down.norm());
  // A repeating picture starts at another place on every face, or equal faces would look alike.
  Vector2f start = Vector2f::Zero();
  if (!material.fitted) start = Vector2f(corner.x() + 1.7f * corner.y(), 1.3f * corner.z());
  const Vector2f positions[4] = {start, start + Vector2f(extent.x(), 0), start + extent,
                                 start + Vector2f(0, extent.y())};
  const Vector3f normal = down.cross(right).normalized();
  for (const auto& [a, b, c] : {std::array{0, 3, 2}, std::array{0, 2, 1}}) {
    SceneTriangle triangle;
    const int order[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      triangle.corner[k] = corners[order[k]];
      triangle.texture_position[k] = positions[order[k]];
      triangle.normal[k] = normal;
    }
    triangle.material = material.index;
    triangle.kind = kind;
    triangles_.push_back(triangle);
  }
}

void ShapeBuilder::box(const Isometry3f& T, const Vector3f& size, const std::array<FaceMaterial, 6>& faces) {
  const float x = size.x() / 2, y = size.y() / 2, z = size.z();
  const auto face = [&](const Vector3f& corner, const Vector3f& right, const Vector3f& down, int index) {
    quad(T * corner, T.linear() * right, T.linear() * down, faces[static_cast<std::size_t>(index)]);
  };
  const Vector3f down(0, 0, -z);
  face({x, -y, z}, {0, 2 * y, 0}, down, 0);
  face({x, y, z}, {-2 * x, 0, 0}, down, 1);
  face({-x, y, z}, {0, -2 * y, 0}, down, 2);
  face({-x, -y, z}, {2 * x, 0, 0}, down, 3);
  face({-x, -y, z}, {0, 2 * y, 0}, {2 * x, 0, 0}, 4);
  face({x, -y, 0}, {0, 2 * y, 0}, {-2 * x, 0, 0}, 5);
}

void ShapeBuilder::cylinder(const Isometry3f& T, float radius, float top_radius, float height, bool lids,
                            const FaceMaterial& side, const FaceMaterial& lid) {
  const int segments = 24;
  const float circumference = 2 * static_cast<float>(M_PI) * std::max(radius, top_radius);
  const float width = side.fitted ? side.texture_size.x() : circumference;
  const float tall = side.fitted ? side.texture_size.y() : height;
  const auto direction = [](int i) {
    const float angle = 2 * static_cast<float>(M_PI) * static_cast<float>(i) / segments;
    return Vector3f(std::cos(angle), std::sin(angle), 0);
  };
  const Vector3f up = Vector3f::UnitZ();
  const auto add = [&](const std::array<Vector3f, 3>& corners, const std::array<Vector3f, 3>& normals,
                       const std::array<Vector2f, 3>& positions, const FaceMaterial& material) {
    SceneTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.corner[k] = T * corners[k];
      triangle.normal[k] = T.linear() * normals[k];
      triangle.texture_position[k] = positions[k];
    }
    triangle.material = material.index;
    triangle.kind = kind;
    triangles_.push_back(triangle);
  };
  for (int i = 0; i < segments; ++i) {
    const Vector3f a = direction(i), b = direction(i + 1);
    const Vector3f slope = (radius - top_radius) / height * up;
    const Vector3f na = (a + slope).normalized(), nb = (b + slope).normalized();
    const Vector3f low_a = radius * a, low_b = radius * b;
    const Vector3f high_a = top_radius * a + height * up, high_b = top_radius * b + height * up;
    const float ua = width * static_cast<float>(i) / segments,
                ub = width * static_cast<float>(i + 1) / segments;
    const Vector2f t_low_a(ua, tall), t_low_b(ub, tall), t_high_a(ua, 0), t_high_b(ub, 0);
    if (radius > 0) add({low_a, low_b, high_b}, {na, nb, nb}, {t_low_a, t_low_b, t_high_b}, side);
    if (top_radius > 0) add({low_a, high_b, high_a}, {na, nb, na}, {t_low_a, t_high_b, t_high_a}, side);
    if (!lids) continue;
    const auto lid_position = [&](const Vector3f& p, float r) -> Vector2f {
      if (!lid.fitted) return p.head<2>();
      return lid.texture_size.cwiseProduct(Vector2f::Constant(0.5f) + 0.5f / r * p.head<2>());
    };
    for (const auto& [r, z, n] : {std::tuple{top_radius, height, up}, std::tuple{radius, 0.f, Vector3f(-up)}})
      if (r > 0)
        add({z * up, r * a + z * up, r * b + z * up}, {n, n, n},
            {lid_position(Vector3f::Zero(), r), lid_position(r * a, r), lid_position(r * b, r)}, lid);
  }
}

void ShapeBuilder::mesh(const Isometry3f& T, const std::vector<Vector3f>& vertices,
                        const std::vector<int>& indices, const FaceMaterial& material) {
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    SceneTriangle triangle;
    Vector3f local[3];
    for (std::size_t k = 0; k < 3; ++k) local[k] = vertices[static_cast<std::size_t>(indices[i + k])];
    const Vector3f normal = (local[1] - local[0]).cross(local[2] - local[0]).normalized();
    Eigen::Index axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    for (int k = 0; k < 3; ++k) {
      triangle.corner[k] = T * local[k];
      triangle.normal[k] = T.linear() * normal;
      triangle.texture_position[k] = Vector2f(local[k][axis == 0 ? 1 : 0], -local[k][axis == 2 ? 1 : 2]);
    }
    triangle.material = material.index;
    triangle.kind = kind;
    triangles_.push_back(triangle);
  }
}

}  // namespace lcmslam
