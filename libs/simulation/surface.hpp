#pragma once
// What a ray meets: reflectivity, normal and light at a point of a triangle.

#include <Eigen/Geometry>
#include <cmath>

#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/scene.hpp>

namespace lcmslam {

/// Interpolates inside one triangle, weights u and v of corners 1 and 2.
template <class Value>
Value interpolate_corners(const Value (&corners)[3], float u, float v) {
  return (1 - u - v) * corners[0] + u * corners[1] + v * corners[2];
}

/// Unit normal on the side that the ray comes from (both sides of a triangle are seen).
inline Eigen::Vector3f facing_normal(const SceneTriangle& triangle, float u, float v,
                                     const Eigen::Vector3f& ray) {
  const Eigen::Vector3f normal = interpolate_corners(triangle.normal, u, v).normalized();
  return normal.dot(ray) > 0 ? Eigen::Vector3f(-normal) : normal;
}

/// Reflectivities (0..255, blue green red infrared) averaged over `footprint` metres.
inline cv::Vec4f reflectivity(const Scene& scene, const SceneTriangle& triangle, float u, float v,
                              float footprint) {
  const Texture& texture = scene.materials[triangle.material].texture;
  return texture.sample(interpolate_corners(triangle.texture_position, u, v), footprint);
}

/// Light that arrives at a point: ambient (a little more from above) and the lamps, Lambert's law.
inline float light_at(const Scene& scene, const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  float light = scene.ambient * (0.9f + 0.1f * normal.z());
  for (const SceneLight& lamp : scene.lights) {
    const Eigen::Vector3f towards = lamp.position - point;
    const float squared = towards.squaredNorm(), cosine = towards.dot(normal);
    if (cosine > 0) light += lamp.power * cosine / (std::sqrt(squared) * (1 + squared));
  }
  return light;
}

}  // namespace lcmslam
