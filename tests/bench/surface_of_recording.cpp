// The dense surface of a recording at its true poses, as picture and mesh, for the eye. Keyframes are those
// that the mappers would take. --frames writes them (depth after the filter, without the lens's distortion)
// for others to fuse, and --beside shows what they made of them on the right, from the same place:
//   build/release/bin/surface_of_recording ../shared/data/livingroom1 --frames room
//   /usr/bin/python3 tests/bench/open3d_surface.py room open3d.ply
//   build/release/bin/surface_of_recording ../shared/data/livingroom1 --beside open3d.ply --picture room.png

#include <cstdio>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

#include <CLI/CLI.hpp>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/map_store/map_export.hpp>
#include <lcmslam/rendering/map_picture.hpp>
#include <lcmslam/surface/mesh_export.hpp>
#include <lcmslam/surface/surface.hpp>
#include "tests/bench/cpu_time.hpp"

namespace lcmslam {
namespace {

struct Options {
  std::string recording, mesh, picture, frames, beside;
  std::vector<double> viewer = {0, 0, -0.6};
  double turn = 0;
  int width = 800;
};

cv::Mat draw(const ColouredCloud& cloud, const std::string& title, const Options& options,
             const Eigen::Isometry3d& T_world_viewer) {
  PictureRequest request;
  request.view = MapView::front;
  request.title = title;
  request.cloud = &cloud;
  request.resolution = 0.012;
  request.width = options.width;
  request.height = options.width * 3 / 4;
  request.T_world_viewer = T_world_viewer;
  return draw_map(request);
}

/// The same in an image of a lens without distortion: the nearest pixel, because depths do not mix.
cv::Mat without_distortion(const cv::Mat& image, const CameraModel& camera) {
  cv::Mat ideal(image.size(), image.type(), cv::Scalar::all(0));
  const std::size_t bytes = image.elemSize();
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const auto from = camera.project({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1});
      if (!from || !camera.contains(*from)) continue;
      const auto row = static_cast<int>(from->y() + 0.5), column = static_cast<int>(from->x() + 0.5);
      std::copy_n(image.ptr(row, column), bytes, ideal.ptr(v, u));
    }
  return ideal;
}

/// NUMBER.depth.png (mm), NUMBER.colour.png; cameras.txt has a line for each: number, fx, fy, cx, cy, and
/// T_world_camera row by row.
class FrameFolder {
 public:
  FrameFolder(const std::string& folder, const RgbdCalibration& calibration)
      : folder_(folder), calibration_(calibration) {
    if (folder.empty()) return;
    if (!calibration.depth_registered)
      throw std::runtime_error(folder + ": frames are written where depth has the colour camera's pixels");
    std::filesystem::create_directories(folder_);
    cameras_.open(folder_ / "cameras.txt");
  }

  void add(std::size_t number, const RgbdFrame& frame, const Eigen::Isometry3d& T_world_camera) {
    if (folder_.empty()) return;
    const CameraModel& camera = calibration_.colour;
    const std::string name = (folder_ / std::to_string(number)).string();
    cv::imwrite(name + ".depth.png", without_distortion(frame.depth, camera));
    cv::imwrite(name + ".colour.png", without_distortion(frame.colour, camera));
    cameras_ << number << ' ' << camera.fx << ' ' << camera.fy << ' ' << camera.cx << ' ' << camera.cy;
    for (int k = 0; k < 16; ++k) cameras_ << ' ' << T_world_camera.matrix()(k / 4, k % 4);
    cameras_ << '\n';
  }

 private:
  std::filesystem::path folder_;
  const RgbdCalibration& calibration_;
  std::ofstream cameras_;
};

void run(const Options& options) {
  const auto source = open_dataset(options.recording);
  const RgbdCalibration& calibration = source->calibration();
  const Eigen::Isometry3d T_truth_camera =
      source->truth_frame() == "camera" ? Eigen::Isometry3d::Identity() : calibration.T_robot_camera;
  Surface surface(calibration);
  DepthFilter filter(calibration);
  FrameFolder frames(options.frames, calibration);
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
    frames.add(i, frame, T);
  }
  if (times.empty()) throw std::runtime_error(options.recording + ": no frame has a true pose");
  const Mesh mesh = surface.mesh();
  std::printf("%zu keyframes, %.1f ms each (p95 %.1f), %zu triangles, %.0f MB\n", times.size(),
              quantile(times, 0.5), quantile(times, 0.95), mesh.triangles.size(),
              static_cast<double>(surface.memory_bytes()) / 1e6);
  if (!options.mesh.empty()) save_mesh(FilePlace(options.mesh), mesh);
  if (options.picture.empty()) return;
  const Eigen::Isometry3d viewer =
      first * Eigen::Translation3d(options.viewer[0], options.viewer[1], options.viewer[2]) *
      Eigen::AngleAxisd(options.turn, Eigen::Vector3d::UnitY());
  cv::Mat picture = draw({mesh.vertices, mesh.colours, mesh.normals, {}}, "lcmslam", options, viewer);
  if (!options.beside.empty())
    cv::hconcat(picture, draw(load_ply(options.beside), "Open3D", options, viewer), picture);
  save_picture(FilePlace(options.picture), picture);
}

}  // namespace
}  // namespace lcmslam

int main(int argc, char** argv) {
  CLI::App app("The dense surface of a recording at its true poses");
  lcmslam::Options options;
  app.add_option("recording", options.recording, "a folder that lcmslam import reads")->required();
  app.add_option("--mesh", options.mesh, "file: .ply, .obj or .glb");
  app.add_option("--picture", options.picture, "file: .png, from behind the first camera");
  app.add_option("--viewer", options.viewer, "where from, in the first camera's frame (x y z, m)")
      ->expected(3);
  app.add_option("--turn", options.turn, "rad, of the viewer to the right");
  app.add_option("--width", options.width, "pixels");
  app.add_option("--frames", options.frames, "folder: the keyframes that were fused");
  app.add_option("--beside", options.beside, "a .ply of vertices with normals, to show on the right");
  CLI11_PARSE(app, argc, argv);
  try {
    lcmslam::run(options);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
