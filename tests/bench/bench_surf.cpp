// SURF beside dlib's on one image with texture at all scales, VGA.
//   build/release/bin/bench_surf --benchmark_repetitions=10 --benchmark_report_aggregates_only=true
// What counts is the ratio to dlib in the same run: cpu_time with one thread, real_time with two.

#include <benchmark/benchmark.h>

#include <lcmslam/parallel/instruction_set.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/unit/surf/blob_scene.hpp"
#include "tests/unit/surf/dlib_surf.hpp"

namespace lcmslam {
namespace {

const cv::Mat& image() {
  static const cv::Mat drawn = [] {
    cv::Mat scene = test::random_scene(1, 420, 6000).draw(640, 480, {1, 0, 320, 240}, 0.5, 60),
            noise(480, 640, CV_8U);
    cv::RNG(7).fill(noise, cv::RNG::NORMAL, 8, 3);  // of a camera
    return cv::Mat(scene + noise);
  }();
  return drawn;
}

void detect_and_describe(benchmark::State& state, const SurfSettings& settings, int threads) {
  const int before = cv::getNumThreads();
  cv::setNumThreads(threads);
  Surf surf(settings);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  for (auto _ : state) surf.detectAndCompute(image(), cv::noArray(), keypoints, descriptors);
  state.counters["keypoints"] = static_cast<double>(keypoints.size());
  cv::setNumThreads(before);
}

SurfSettings at_most(int count) {
  SurfSettings settings;
  settings.hessian_threshold = 5;
  settings.budget.max_features = count;
  return settings;
}

// Keypoints, threads.
void surf(benchmark::State& state) {
  detect_and_describe(state, at_most(static_cast<int>(state.range(0))), static_cast<int>(state.range(1)));
}
BENCHMARK(surf)
    ->Args({1000, 1})
    ->Args({500, 1})
    ->Args({1000, 2})
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

void surf_extended(benchmark::State& state) {
  SurfSettings settings = at_most(1000);
  settings.extended = true;
  detect_and_describe(state, settings, 1);
}
BENCHMARK(surf_extended)->Unit(benchmark::kMillisecond);

void surf_without_avx2(benchmark::State& state) {
  const InstructionSet before = limit_instruction_set(InstructionSet::portable);
  detect_and_describe(state, at_most(1000), 1);
  limit_instruction_set(before);
}
BENCHMARK(surf_without_avx2)->Unit(benchmark::kMillisecond);

#ifdef LCMSLAM_HAS_DLIB
void dlib_surf(benchmark::State& state) {
  std::size_t count = 0;
  for (auto _ : state)
    count = dlib::get_surf_points(dlib::cv_image<unsigned char>(image()), state.range(0), 1.).size();
  state.counters["keypoints"] = static_cast<double>(count);
}
BENCHMARK(dlib_surf)->Arg(1000)->Arg(500)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace lcmslam
