// How good the dense surface of a simulated room is: the mesh's vertices against the true surfaces, and what
// of the seen surfaces it shows. One row a seed and head; the last seed's mesh is written when a file is
// named.
//   build/release/bin/surface_quality [--seeds 10] [--head rgbd] [--scene kitchen] [--mesh kitchen.glb]

#include <cstdio>
#include <iostream>

#include <CLI/CLI.hpp>

#include <lcmslam/cloud/kd_tree.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/planes/range_error.hpp>
#include <lcmslam/simulation/ray_caster.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include <lcmslam/surface/mesh_export.hpp>
#include <lcmslam/surface/surface.hpp>
#include "tests/bench/cpu_time.hpp"
#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

/// Walls that lie in layers of voxels would be right by chance: the map stands askew.
Eigen::Isometry3d map_in_world() {
  return Eigen::Translation3d(0.1234, 0.4567, 0.0043) *
         Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.05, 0.1, 1).normalized()) * Eigen::Isometry3d::Identity();
}

constexpr float shown_within = 0.02f;  // m from a seen point, of the mesh

/// Times at which the robot has moved or turned as far as from keyframe to keyframe.
std::vector<Utime> keyframe_times(const Simulation& simulation) {
  std::vector<Utime> times;
  Eigen::Isometry3d last;
  for (Utime t = simulation.start(); t < simulation.end(); t += 100'000) {
    const Eigen::Isometry3d T = simulation.T_world_robot(t);
    if (!times.empty() && distance_between(last, T) < 0.2 && angle_between(last, T) < 0.2) continue;
    times.push_back(t);
    last = T;
  }
  return times;
}

/// Surface points that the depth camera looks at within range and not too flatly, from its true poses.
void add_seen(const RayCaster& caster, const Scene& scene, const RgbdCalibration& calibration,
              const SurfaceSettings& settings, const Eigen::Isometry3d& T_world_depth,
              std::vector<Eigen::Vector3f>& seen) {
  const CameraModel& camera = calibration.depth;
  const int step = std::max(1, camera.width / 40);
  const Eigen::Isometry3f T = T_world_depth.cast<float>();
  const double far = std::min(settings.fine_range, calibration.depth_max);
  for (int v = step / 2; v < camera.height; v += step) {
    for (int u = step / 2; u < camera.width; u += step) {
      const Eigen::Vector3f ray = camera.ray({u, v}).cast<float>();
      RayPacket packet;
      const Eigen::Vector3f direction = T.linear() * ray;
      for (int k = 0; k < RayPacket::size; ++k) {
        packet.x[k] = direction.x();
        packet.y[k] = direction.y();
        packet.z[k] = direction.z();
      }
      caster.cast(T.translation(), packet);
      const float range = packet.range[0];
      if (packet.triangle[0] == RayPacket::none || range > far || range < calibration.depth_min) continue;
      const SceneTriangle& triangle = scene.triangles[packet.triangle[0]];
      const float cosine = std::abs(triangle.normal[0].normalized().dot(direction.normalized()));
      if (cosine < std::cos(settings.max_incidence)) continue;
      seen.push_back(T.translation() + range * direction);
    }
  }
}

double share_of(std::vector<double>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double shown_share(const Mesh& mesh, const std::vector<Eigen::Vector3f>& seen) {
  const KdTree tree(mesh.vertices);
  std::size_t shown = 0;
  for (const Eigen::Vector3f& point : seen) {
    shown += tree.nearest(point, shown_within).index >= 0;
  }
  return static_cast<double>(shown) / static_cast<double>(seen.size());
}

struct Options {
  std::string scene = "kitchen", mesh;
  std::string head = "rgbd";
  int seeds = 1;
};

void run(const Options& options, std::uint64_t seed) {
  SimulationSettings simulated;
  simulated.scene = source_folder().string() + "/config/scenes/" + options.scene + ".yaml";
  simulated.head = options.head;
  simulated.seed = seed;
  const Simulation simulation(simulated);
  const Scene scene = load_scene(simulated.scene);
  const RayCaster caster(scene);
  const RgbdCalibration& calibration = simulation.calibration();
  const SurfaceSettings settings;
  Surface surface(calibration, settings);
  DepthFilter filter(calibration);
  RangeError range_error(calibration, {});
  std::vector<Eigen::Vector3f> seen;
  double fusing = 0;
  std::int64_t id = 0;
  for (const Utime t : keyframe_times(simulation)) {
    RgbdFrame frame = simulation.render(t);
    filter(frame.depth, frame.amplitude);
    range_error.learn(frame.depth, frame.depth_utime);
    range_error.correct(frame.depth);
    const auto T_world_camera = [&](Utime when) {
      return simulation.T_world_robot(when) * calibration.T_robot_camera;
    };
    const Eigen::Isometry3d T_colour = T_world_camera(frame.utime),
                            T_depth = T_world_camera(calibration.depth_time(frame.depth_utime));
    const double begin = cpu_milliseconds();
    surface.fuse(id++, frame, map_in_world().inverse() * T_colour, T_colour.inverse() * T_depth);
    fusing += cpu_milliseconds() - begin;
    add_seen(caster, scene, calibration, settings, T_depth * calibration.T_colour_depth, seen);
  }
  const double begin = cpu_milliseconds();
  Mesh mesh = surface.mesh();
  const double meshing = cpu_milliseconds() - begin;
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = map_in_world().cast<float>() * vertex;
  for (Eigen::Vector3f& normal : mesh.normals) normal = map_in_world().linear().cast<float>() * normal;
  std::vector<double> errors;
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    errors.push_back(simulation.distance_to_surface(vertex.cast<double>()));
  std::printf("%4d  %-5s %9d %9zu %9.2f %9.2f %9.1f %9.1f %9.1f %9.0f\n", static_cast<int>(seed),
              options.head.c_str(), static_cast<int>(id), mesh.triangles.size(), 1000 * share_of(errors, 0.5),
              1000 * share_of(errors, 0.95), 100 * shown_share(mesh, seen), fusing / static_cast<double>(id),
              meshing, static_cast<double>(surface.memory_bytes()) / 1e6);
  std::fflush(stdout);
  if (!options.mesh.empty()) save_mesh(FilePlace(options.mesh), mesh);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  CLI::App app("The dense surface of a simulated room against the truth");
  lcmslam::Options options;
  app.add_option("--scene", options.scene, "of config/scenes");
  app.add_option("--head", options.head, "rgbd or tof");
  app.add_option("--seeds", options.seeds, "how many");
  app.add_option("--mesh", options.mesh, "file for the last mesh: .ply, .obj or .glb");
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "seed  head  keyframes triangles median/mm    p95/mm   shown/%%   ms/fuse   ms/mesh        MB\n");
  for (int seed = 1; seed <= options.seeds; ++seed) lcmslam::run(options, static_cast<std::uint64_t>(seed));
}
