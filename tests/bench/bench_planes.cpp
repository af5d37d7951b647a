// What the planes of a VGA depth image cost, one thread.
//   build/release/bin/bench_planes --benchmark_repetitions=10 --benchmark_report_aggregates_only=true
// CAPE, the peer in the literature, runs at 300 Hz (3.3 ms an image); no package brings it.

#include <benchmark/benchmark.h>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/planes/plane_map.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

struct Images {
  RgbdCalibration calibration;
  std::vector<cv::Mat> depths;
  std::vector<Eigen::Isometry3d> poses;  // T_world_depth
};

/// Eight of the kitchen's path.
const Images& images() {
  static const Images made = [] {
    const Scene scene = load_scene(source_folder() / "config/scenes/kitchen.yaml");
    const RayCaster caster(scene);
    const SensorHead head = make_head("rgbd", scene, caster, {640, 480});
    const PlanarPath path(scene.path);
    DepthFilter filter(head.calibration);
    Images all{head.calibration, {}, {}};
    for (int i = 0; i < 8; ++i) {
      RgbdFrame frame;
      all.poses.push_back(path.pose(path.duration() * (i + 0.5) / 8) * head.calibration.T_robot_camera *
                          head.calibration.T_colour_depth);
      head.depth->render(all.poses.back(), PixelNoise(1, 2, i), 1, frame);
      filter(frame.depth, frame.amplitude);
      all.depths.push_back(frame.depth);
    }
    return all;
  }();
  return made;
}

void planes_of_frame(benchmark::State& state) {
  cv::setNumThreads(1);
  FramePlaneFinder finder(images().calibration);
  std::size_t i = 0, planes = 0;
  for (auto _ : state) planes = finder(images().depths[i++ % images().depths.size()]).planes.size();
  state.counters["planes"] = static_cast<double>(planes);
}
BENCHMARK(planes_of_frame)->Unit(benchmark::kMillisecond);

void cell_moments_alone(benchmark::State& state) {
  CellMoments cells(images().calibration, 640 / FramePlaneSettings().cells_across);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(cells(images().depths[i++ % images().depths.size()]).data());
}
BENCHMARK(cell_moments_alone)->Unit(benchmark::kMillisecond);

void into_the_map(benchmark::State& state) {
  FramePlaneFinder finder(images().calibration);
  std::vector<FramePlanes> found;
  for (const cv::Mat& depth : images().depths) found.push_back(finder(depth));
  PlaneMap map;
  std::size_t i = 0;
  for (auto _ : state) {
    map.insert(found[i], finder.cells(), images().poses[i]);
    i = (i + 1) % found.size();
  }
}
BENCHMARK(into_the_map)->Unit(benchmark::kMillisecond);

void outlines(benchmark::State& state) {
  FramePlaneFinder finder(images().calibration);
  PlaneMap map;
  for (std::size_t k = 0; k < images().depths.size(); ++k)
    map.insert(finder(images().depths[k]), finder.cells(), images().poses[k]);
  for (auto _ : state) benchmark::DoNotOptimize(map.patches().size());
}
BENCHMARK(outlines)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
