// What a keyframe costs the dense surface at 1 cm, one thread: its parts, and the mesh of what changed.
//   build/release/bin/bench_surface --benchmark_repetitions=10 --benchmark_report_aggregates_only=true
// The kitchen from its path, a VGA depth camera and the simulation's own.

#include <benchmark/benchmark.h>

#include <opencv2/rgbd/volume.hpp>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>
#include <lcmslam/surface/surface.hpp>
#include <lcmslam/surface/view_fusion.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

/// Forty keyframes of the kitchen's path, depth filtered, without colour: what looking costs is the same.
struct Drive {
  RgbdCalibration calibration;
  std::vector<RgbdFrame> frames;
  std::vector<Eigen::Isometry3d> poses;  // T_world_camera
};

const Drive& drive(bool vga) {
  const auto make = [](bool large) {
    const Scene scene = load_scene(source_folder() / "config/scenes/kitchen.yaml");
    const RayCaster caster(scene);
    const SensorHead head = make_head("rgbd", scene, caster, large ? cv::Size(640, 480) : cv::Size());
    const PlanarPath path(scene.path);
    DepthFilter filter(head.calibration);
    Drive made{head.calibration, {}, {}};
    for (int i = 0; i < 40; ++i) {
      const Eigen::Isometry3d T =
          path.pose(path.duration() * (i + 0.5) / 40) * head.calibration.T_robot_camera;
      RgbdFrame frame;
      head.depth->render(T * head.calibration.T_colour_depth, PixelNoise(1, 2, i), 1, frame);
      filter(frame.depth, frame.amplitude);
      frame.colour = cv::Mat(head.calibration.colour.height, head.calibration.colour.width, CV_8UC3,
                             cv::Scalar(90, 120, 150));
      made.frames.push_back(frame);
      made.poses.push_back(T);
    }
    return made;
  };
  static const Drive small = make(false), large = make(true);
  return vga ? large : small;
}

void fuse_keyframe(benchmark::State& state) {
  cv::setNumThreads(1);
  const Drive& data = drive(state.range(0) > 0);
  std::size_t blocks = 0;
  while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(data.frames.size()))) {
    Surface surface(data.calibration);
    for (std::size_t i = 0; i < data.frames.size(); ++i)
      surface.fuse(static_cast<std::int64_t>(i), data.frames[i], data.poses[i]);
    blocks = surface.fine().size();
  }
  state.counters["blocks"] = static_cast<double>(blocks);
}
BENCHMARK(fuse_keyframe)->ArgName("vga")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

/// The parts: the small images, their planes, the blocks, what is kept.
void part(benchmark::State& state, int which) {
  cv::setNumThreads(1);
  const Drive& data = drive(true);
  const SurfaceSettings settings;
  const SurfaceViewMaker maker(data.calibration, settings);
  VoxelBlocks fine(settings.voxel_size, settings.truncation),
      coarse(settings.coarse_voxel_size, settings.truncation);
  std::size_t i = 0;
  std::int64_t fusion = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const RgbdFrame& frame = data.frames[i];
    const Eigen::Isometry3d T = data.poses[i] * data.calibration.T_colour_depth;
    i = (i + 1) % data.frames.size();
    const SurfaceImage image = maker.image(frame);
    const SurfaceView view = maker.view(image);
    ++fusion;
    state.ResumeTiming();
    if (which == 0) benchmark::DoNotOptimize(maker.image(frame).depth.data);
    if (which == 1) benchmark::DoNotOptimize(maker.view(image).depth.data());
    if (which == 2) fuse_view(view, T, settings, settings.fine_range, fusion, fine);
    if (which == 3) fuse_view(view, T, settings, settings.max_range, fusion, coarse);
    if (which == 4) benchmark::DoNotOptimize(KeptView(image).memory_bytes());
  }
  std::size_t seen = 0;  // by the last look
  for (const VoxelBlocks::Entry& entry : fine.entries()) seen += entry.changed == fusion;
  if (which == 2) state.counters["blocks"] = static_cast<double>(seen);
  if (which == 4)
    state.counters["bytes"] = static_cast<double>(KeptView(maker.image(data.frames[20])).memory_bytes());
}
BENCHMARK_CAPTURE(part, image, 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, view, 1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, fine_blocks, 2)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, coarse_blocks, 3)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, kept, 4)->Unit(benchmark::kMillisecond);

/// The peer: OpenCV's hashed distance field without colour, at the same voxels and truncation.
void opencv_hash_tsdf(benchmark::State& state) {
  cv::setNumThreads(1);
  const Drive& data = drive(true);
  const SurfaceSettings settings;
  const auto voxel = static_cast<float>(settings.voxel_size);
  const CameraModel& camera = data.calibration.depth;
  std::vector<cv::Mat> depths(data.frames.size());
  for (std::size_t i = 0; i < depths.size(); ++i) data.frames[i].depth.convertTo(depths[i], CV_32F);
  const cv::kinfu::Intr lens(static_cast<float>(camera.fx), static_cast<float>(camera.fy),
                             static_cast<float>(camera.cx), static_cast<float>(camera.cy));
  while (state.KeepRunningBatch(static_cast<benchmark::IterationCount>(data.frames.size()))) {
    const auto volume = cv::kinfu::makeVolume(cv::kinfu::VolumeType::HASHTSDF, voxel, cv::Matx44f::eye(),
                                              0.25f, static_cast<float>(settings.truncation) * voxel, 64,
                                              static_cast<float>(settings.fine_range), cv::Vec3i::all(16));
    for (std::size_t i = 0; i < data.frames.size(); ++i) {
      const Eigen::Matrix4f T = (data.poses[i] * data.calibration.T_colour_depth).matrix().cast<float>();
      cv::Matx44f pose;
      for (int k = 0; k < 16; ++k) pose(k / 4, k % 4) = T(k / 4, k % 4);
      volume->integrate(depths[i], 1000, pose, lens, static_cast<int>(i));
    }
  }
}
BENCHMARK(opencv_hash_tsdf)->Unit(benchmark::kMillisecond);

void mesh_after_keyframe(benchmark::State& state) {
  const Drive& data = drive(true);
  Surface surface(data.calibration);
  std::size_t i = 0;
  SurfaceMesh mesh{SurfaceSettings()};
  for (auto _ : state) {
    state.PauseTiming();
    surface.fuse(static_cast<std::int64_t>(i), data.frames[i % 40], data.poses[i % 40]);
    ++i;
    state.ResumeTiming();
    mesh.update(surface.fine(), surface.coarse());
  }
}
BENCHMARK(mesh_after_keyframe)->Unit(benchmark::kMillisecond)->Iterations(40);

}  // namespace
}  // namespace lcmslam
