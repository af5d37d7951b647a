// What it costs to bring a VGA depth image with a geometry of its own into the colour camera, whole and
// around 600 features alone: the simulated kitchen's rgbd head, one thread.
//   build/release/bin/bench_depth_registration --benchmark_repetitions=10
//   --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/simulation/simulation.hpp>

#include "tests/support/source_folder.hpp"

namespace lcmslam {
namespace {

struct Shot {
  RgbdCalibration calibration;
  RgbdFrame frame;
  std::vector<cv::Point2f> pixels;
};

const Shot& shot() {
  static const Shot one = [] {
    SimulationSettings settings;
    settings.scene = source_folder() / "config/scenes/kitchen.yaml";
    settings.head = "rgbd";
    const Simulation simulation(settings);
    Shot s{simulation.calibration(), simulation.render(simulation.start() + 1'000'000), {}};
    Random random(1);
    for (int i = 0; i < 600; ++i)
      s.pixels.emplace_back(static_cast<float>(random.uniform(20, 620)),
                            static_cast<float>(random.uniform(20, 460)));
    return s;
  }();
  return one;
}

void whole_image(benchmark::State& state) {
  const DepthRegistration registration(shot().calibration);
  for (auto _ : state) benchmark::DoNotOptimize(registration(shot().frame));
}
BENCHMARK(whole_image)->Unit(benchmark::kMillisecond);

void whole_image_then_features(benchmark::State& state) {
  const DepthRegistration registration(shot().calibration);
  for (auto _ : state)
    benchmark::DoNotOptimize(depth_at_pixels(registration(shot().frame), shot().calibration, shot().pixels));
}
BENCHMARK(whole_image_then_features)->Unit(benchmark::kMillisecond);

void around_features(benchmark::State& state) {
  const DepthRegistration registration(shot().calibration);
  for (auto _ : state) benchmark::DoNotOptimize(registration.depth_at_pixels(shot().frame, shot().pixels));
}
BENCHMARK(around_features)->Unit(benchmark::kMillisecond);

void around_features_of_registered_depth(benchmark::State& state) {
  RgbdCalibration calibration = shot().calibration;
  calibration.depth_registered = true;
  const DepthRegistration registration(calibration);
  for (auto _ : state) benchmark::DoNotOptimize(registration.depth_at_pixels(shot().frame, shot().pixels));
}
BENCHMARK(around_features_of_registered_depth)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
