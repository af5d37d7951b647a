#pragma once
// Settings of the dense surface and all of its parts.

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

struct SurfaceSettings {
  double voxel_size = 0.01;
  double fine_range = 3.5;
  double coarse_voxel_size = 0.04;
  double max_range = 6;
  double truncation = 4;
  double max_incidence = 1.3;
  double best_sigma = 0.002;
  double max_looks = 200;
  double min_looks = 0.06;
  double memory = 256;
  double kept_memory = 64;
  double moved_distance = 0.004;
  double moved_angle = 0.002;

  void describe(SettingsVisitor& s) {
    s.number("voxel_size", voxel_size, "m", {0.002, 1}, "of the surface near the camera");
    s.number("fine_range", fine_range, "m", {0.1, 100}, "from the camera to which it makes fine voxels");
    s.number("coarse_voxel_size", coarse_voxel_size, "m", {0.004, 4},
             "of the surface where there is no finer one");
    s.require(coarse_voxel_size >= 2 * voxel_size, "coarse_voxel_size", "must be at least twice voxel_size");
    s.number("max_range", max_range, "m", {0.1, 100}, "from the camera beyond which nothing is fused");
    s.number("truncation", truncation, "", {2, 20}, "voxels from a surface to which its distance is kept");
    s.number("max_incidence", max_incidence, "rad", {0.1, 1.5},
             "steepest view of a surface that is fused, from the viewing ray to the normal");
    s.number("best_sigma", best_sigma, "m", {1e-5, 1},
             "standard deviation of a depth whose look counts fully; worse ones count by their variance");
    s.number("max_looks", max_looks, "", {1, 1000},
             "that a voxel remembers: what moved away is gone after as many others");
    s.number("min_looks", min_looks, "", {0.02, 1000}, "full looks that a voxel needs to be shown");
    s.number("memory", memory, "MB", {1, 1e5}, "of all voxels; beyond, those farthest from the camera go");
    s.number("kept_memory", kept_memory, "MB", {0, 1e5},
             "of the keyframes' images; beyond, the oldest go, and their places do not bend any more");
    s.number("moved_distance", moved_distance, "m", {1e-4, 10}, "of a keyframe's pose that fuses it again");
    s.number("moved_angle", moved_angle, "rad", {1e-4, 3}, "of a keyframe's pose that fuses it again");
  }
};

}  // namespace lcmslam
