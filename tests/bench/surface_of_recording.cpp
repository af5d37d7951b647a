// The dense surface of a recording at its true poses, as picture and mesh, for the eye. Keyframes are those
// that the mappers would take; --poses writes which they were (number of the frame, T_world_camera row by
// row), so that others (Open3D) can fuse the same.
//   build/release/bin/surface_of_recording ../shared/data/livingroom1 --picture room.png [--mesh room.glb]

#include <cstdio>
#include <fstream>
#include <iostream>

#include <CLI/CLI.hpp>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/rendering/map_picture.hpp>
#include <lcmslam/surface/mesh_export.hpp>
#include <lcmslam/surface/surface.hpp>
#include "tests/bench/cpu_time.hpp"

namespace lcmslam {
namespace {

struct Options {
  std::string recording, mesh, picture, poses;
};

void write_picture(const std::string& file, const Mesh& mesh, const Eigen::Isometry3d& T_world_viewer) {
  ColouredCloud cloud;
  cloud.points = mesh.vertices;
  cloud.colours = mesh.colours;
  cloud.normals = mesh.normals;
  PictureRequest request;
  request.view = MapView::front;
  request.cloud = &cloud;
  request.resolution = 0.012;
  request.T_world_viewer = T_world_viewer;
  save_picture(FilePlace(file), draw_map(request));
}

void run(const Options& options) {
  const auto source = open_dataset(options.recording);
  const RgbdCalibration& calibration = source->calibration();
  const Eigen::Isometry3d T_truth_camera =
      source->truth_frame() == "camera" ? Eigen::Isometry3d::Identity() : calibration.T_robot_camera;
  Surface surface(calibration);
  DepthFilter filter(calibration);
  std::ofstream poses(options.poses);
  std::vector<double> times;
  Eigen::Isometry3d last, first;
  for (std::size_t i = 0; i < source->size(); ++i) {
    const auto T_truth = pose_at(source->truth(), source->entry(i).utime);
    if (!T_truth) continue;
    const Eigen::Isometry3d T = *T_truth * T_truth_camera;
    if (!times.empty() && distance_between(last, T) < 0.15 && angle_between(last, T) < 0.15) continue;
    const auto encoded = source->frame(i);
    if (!encoded) continue;
    RgbdFrame frame = decode(*encoded);
    filter(frame.depth, frame.amplitude);
    const double begin = cpu_milliseconds();
    surface.fuse(static_cast<std::int64_t>(i), frame, T);
    times.push_back(cpu_milliseconds() - begin);
    if (times.size() == 1) first = T;
    last = T;
    poses << i;
    for (int k = 0; k < 16; ++k) poses << ' ' << T.matrix()(k / 4, k % 4);
    poses << '\n';
  }
  if (times.empty()) throw std::runtime_error(options.recording + ": no frame has a true pose");
  const Mesh mesh = surface.mesh();
  std::printf("%zu keyframes, %.1f ms each (p95 %.1f), %zu triangles, %.0f MB\n", times.size(),
              quantile(times, 0.5), quantile(times, 0.95), mesh.triangles.size(),
              static_cast<double>(surface.memory_bytes()) / 1e6);
  if (!options.mesh.empty()) save_mesh(FilePlace(options.mesh), mesh);
  if (options.picture.empty()) return;
  Eigen::Isometry3d viewer = first;
  viewer.translation() -= 0.6 * first.linear().col(2);
  write_picture(options.picture, mesh, viewer);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  CLI::App app("The dense surface of a recording at its true poses");
  lcmslam::Options options;
  app.add_option("recording", options.recording, "a folder that lcmslam import reads")->required();
  app.add_option("--mesh", options.mesh, "file: .ply, .obj or .glb");
  app.add_option("--picture", options.picture, "file: .png, from behind the first camera");
  app.add_option("--poses", options.poses, "file: the keyframes that were fused");
  CLI11_PARSE(app, argc, argv);
  try {
    lcmslam::run(options);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
