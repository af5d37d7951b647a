#pragma once
// A small map in every format that we export, and what is in it.

#include <lcmslam/cloud/coloured_cloud.hpp>
#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/map_layers/navigation_grid.hpp>
#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/surface/mesh.hpp>

namespace lcmslam {

struct SampleMap {
  SampleMap();

  Mesh mesh;
  ColouredCloud cloud;
  std::vector<Landmark> landmarks;
  OccupancyGrid occupancy;
  NavigationGrid ground;
  Trajectory trajectory;
};

/// mesh.{ply,obj,glb}, empty.glb, cloud.{ply,pcd}, landmarks.{ply,pcd,csv}, occupancy.bt, ground.{pgm,yaml},
/// robot.{tum,kitti} and robot_times.txt.
void save_exports(const std::filesystem::path& folder, const SampleMap& map);

}  // namespace lcmslam
