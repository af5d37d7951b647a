#pragma once
// A scene: textured triangles, lights, where the robot drives and how its head looks. Read from
// YAML; config/scenes/kitchen.yaml explains the keys.
//
// World frame: the scene's own, z up, floor at z = 0; what lies on it (ramps, sills) is the ground.

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/simulation/ground.hpp>
#include <lcmslam/simulation/texture.hpp>

namespace lcmslam {

enum class SurfaceKind : std::uint8_t { object, floor, ceiling, wall };

/// Corners with their surface normals (towards the room) and texture positions in metres.
struct SceneTriangle {
  Eigen::Vector3f corner[3];
  Eigen::Vector3f normal[3];
  Eigen::Vector2f texture_position[3];
  std::uint16_t material = 0;  ///< index into Scene::materials
  SurfaceKind kind = SurfaceKind::object;
};

struct SceneMaterial {
  std::string name;
  Texture texture;
  bool bare = false;  ///< without any texture: what a bare wall is made of
};

/// A point light. Light arriving at a surface at distance d and incidence angle a: power cos a / (1 + d^2).
struct SceneLight {
  Eigen::Vector3f position;
  float power = 1;
};

/// How the sensor head sits on the robot (colour camera).
struct HeadMount {
  double forward = 0.1;   ///< m, of the robot's centre
  double height = 1.3;    ///< m above the ground
  double tilt = 0.34907;  ///< rad, downwards (20 degrees)
  double pan = 0;         ///< rad, to the left
};

struct Scene {
  std::string name;
  std::vector<SceneTriangle> triangles;
  std::vector<SceneMaterial> materials;
  std::vector<SceneLight> lights;
  float ambient = 0.5f;
  Ground ground;  ///< on the floor, where the robot drives
  HeadMount head;
  std::vector<Eigen::Vector2d> path;      ///< control points of the robot's path, m
  std::vector<Eigen::Vector2d> way_back;  ///< control points from its end to its start; empty: there is none
};

/// Control points of a drive along the path and back to its start, `laps` times; the last lap ends where the
/// path does. Throws std::invalid_argument for more than one lap in a scene without a way back.
std::vector<Eigen::Vector2d> control_points(const Scene& scene, int laps);

/// Throws ConfigError naming file and line.
Scene load_scene(const std::filesystem::path& file);
Scene read_scene(const ConfigNode& config);

}  // namespace lcmslam
