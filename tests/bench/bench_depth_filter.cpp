// What the depth filter costs an image, one thread: whole, part by part, and over sizes.
//   build/release/bin/bench_depth_filter --benchmark_repetitions=10 --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/simulation/planar_path.hpp>
#include <lcmslam/simulation/sensor_head.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

struct Images {
  RgbdCalibration calibration;
  std::vector<RgbdFrame> frames;
};

/// Four of the kitchen's path.
Images render(const std::string& head_name, cv::Size size) {
  const Scene scene = load_scene(source_folder() / "config/scenes/kitchen.yaml");
  const RayCaster caster(scene);
  const SensorHead head = make_head(head_name, scene, caster, size);
  const PlanarPath path(scene.path);
  Images images{head.calibration, {}};
  for (int i = 0; i < 4; ++i) {
    RgbdFrame frame;
    head.depth->render(path.pose(path.duration() * (i + 0.5) / 4) * head.calibration.T_robot_camera *
                           head.calibration.T_colour_depth,
                       PixelNoise(1, 2, i), 1, frame);
    images.frames.push_back(frame);
  }
  return images;
}

void run(benchmark::State& state, const std::string& head, const DepthFilterSettings& settings) {
  cv::setNumThreads(1);
  const int width = static_cast<int>(state.range(0));
  const Images images = render(head, {width, width == 176 ? 144 : width * 3 / 4});
  DepthFilter filter(images.calibration, settings);
  cv::Mat depth;
  std::size_t i = 0;
  for (auto _ : state) {
    const RgbdFrame& frame = images.frames[i++ % images.frames.size()];
    frame.depth.copyTo(depth);  // 0.03 ms at VGA
    filter(depth, frame.amplitude);
    benchmark::DoNotOptimize(depth.data);
  }
}

void depth_filter_tof(benchmark::State& state) {
  run(state, "tof", {});
}
void depth_filter_rgbd(benchmark::State& state) {
  run(state, "rgbd", {});
}
BENCHMARK(depth_filter_tof)->Arg(176)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);
BENCHMARK(depth_filter_rgbd)->Arg(176)->Arg(320)->Arg(640)->Unit(benchmark::kMillisecond);

void part(benchmark::State& state, const char* name) {
  DepthFilterSettings settings;
  settings.parts = {name};
  run(state, "tof", settings);
}
BENCHMARK_CAPTURE(part, amplitude, "amplitude")->Arg(640)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, jump_edges, "jump_edges")->Arg(640)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, speckle, "speckle")->Arg(640)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part, bilateral, "bilateral")->Arg(640)->Unit(benchmark::kMillisecond);

/// Peers of other purposes, for orientation: the same kind of work in OpenCV.
void opencv_gradient(benchmark::State& state) {
  cv::setNumThreads(1);
  const Images images = render("tof", {640, 480});
  cv::Mat depth, highest, lowest, span;
  std::size_t i = 0;
  for (auto _ : state) {
    images.frames[i++ % images.frames.size()].depth.copyTo(depth);
    cv::dilate(depth, highest, cv::Mat());
    cv::erode(depth, lowest, cv::Mat());
    cv::subtract(highest, lowest, span);
    depth.setTo(0, span > 100);
    benchmark::DoNotOptimize(depth.data);
  }
}
BENCHMARK(opencv_gradient)->Unit(benchmark::kMillisecond);

void opencv_bilateral(benchmark::State& state) {
  cv::setNumThreads(1);
  const Images images = render("tof", {640, 480});
  cv::Mat depth, smoothed;
  std::size_t i = 0;
  for (auto _ : state) {
    images.frames[i++ % images.frames.size()].depth.convertTo(depth, CV_32F, 0.001);
    cv::bilateralFilter(depth, smoothed, 5, 0.03, 1.5);
    benchmark::DoNotOptimize(smoothed.data);
  }
}
BENCHMARK(opencv_bilateral)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
