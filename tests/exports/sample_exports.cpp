#include "tests/exports/sample_exports.hpp"

#include <lcmslam/evaluation/pose_text.hpp>
#include <lcmslam/map_layers/export_navigation_grid.hpp>
#include <lcmslam/map_layers/octomap/export_octomap.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/surface/mesh_export.hpp>
#include "tests/support/filled_occupancy.hpp"
#include "tests/unit/map_store/sample_map.hpp"

namespace lcmslam {
namespace {

/// A tetrahedron without symmetry.
Mesh tetrahedron() {
  Mesh mesh;
  mesh.vertices = {{0.125f, -0.25f, 0.0625f}, {1.5f, 0, 0}, {0, 2.25f, 0.1f}, {0.3f, 0, 3.75f}};
  mesh.normals = {{-0.6f, -0.8f, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.colours = {{0, 0, 255}, {0, 255, 0}, {255, 0, 0}, {10, 100, 188}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

/// A floor with a box on it, in free space.
OccupancyGrid floor_with_box() {
  OccupancyGrid grid({});
  fill(grid, {Eigen::Vector3f(-1.3f, -1, -0.4f), Eigen::Vector3f(1.8f, 1, 1)}, -20);
  fill(grid, {Eigen::Vector3f(-1.3f, -1, -0.04f), Eigen::Vector3f(1.8f, 1, 0)}, 20);
  fill(grid, {Eigen::Vector3f(0.8f, 0.2f, 0), Eigen::Vector3f(1.2f, 0.5f, 0.6f)}, 20);
  return grid;
}

NavigationGrid ground_of(const OccupancyGrid& occupancy) {
  NavigationSettings settings;
  settings.reach = 3;
  return make_navigation_grid(occupancy, settings, planar_pose(0.02, 0.02, 0));
}

}  // namespace

SampleMap::SampleMap()
    : mesh(tetrahedron()),
      cloud(random_cloud(3, 40, true)),
      occupancy(floor_with_box()),
      ground(ground_of(occupancy)) {
  Random random(5);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d at = random_point(random);
    landmarks.push_back(landmark(i + 1, at.x(), at.y(), at.z()));
    landmarks.back().log_odds = 1.25 + i;
    trajectory.push_back({1'700'000'000'123'456 + 100'001 * i, random_pose(random)});
  }
}

void save_exports(const std::filesystem::path& folder, const SampleMap& map) {
  for (const char* name : {"mesh.ply", "mesh.obj", "mesh.glb"}) save_mesh(folder / name, map.mesh);
  save_mesh_glb(folder / "empty.glb", {});
  save_ply(folder / "cloud.ply", map.cloud);
  save_pcd(folder / "cloud.pcd", map.cloud);
  save_ply(folder / "landmarks.ply", map.landmarks);
  save_pcd(folder / "landmarks.pcd", map.landmarks);
  save_csv(folder / "landmarks.csv", map.landmarks);
  save_octomap(folder / "occupancy.bt", map.occupancy);
  save_navigation_grid(HeldFolder(folder), "ground", map.ground);
  save_tum(folder / "robot.tum", map.trajectory, {"map", "robot"});
  save_kitti(folder / "robot.kitti", map.trajectory);
}

}  // namespace lcmslam
