// The filter's cost beside the size of its map.
//   build/release/bin/bench_fastslam --benchmark_repetitions=5 --benchmark_report_aggregates_only=true
// Look at the CPU column: the machine may be shared. `wall` is real time, with the threads named.
//
// filter: landmarks of known identity, so that association costs nothing: proposal, weights, updates and
// resampling of all particles. whole_step: features offered with descriptors, a building of rooms mapped by
// driving; p50 and p95 are CPU times of steps after the map is full.

#include <benchmark/benchmark.h>

#include <time.h>
#include <cstdlib>
#include <opencv2/core/utility.hpp>
#include <set>
#include <string>

#include <lcmslam/fastslam/fastslam.hpp>
#include "tests/bench/landmark_scene.hpp"

namespace lcmslam {
namespace {

using synthetic::Building;
using synthetic::SceneStep;
using synthetic::Wall;

double process_milliseconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

FastSlam mapped(Wall& wall, FastSlamSettings settings, int seen) {
  FastSlam slam(settings);
  for (int i = 0; i < 2 * wall.lap(); ++i) {
    const SceneStep step = wall.next(seen / 2);
    slam.step(step.motion, step.frame);
  }
  return slam;
}

// All maps together, what is shared counted once, and one of them.
void report_memory(benchmark::State& state, const FastSlam& slam) {
  std::set<const void*> nodes;
  std::size_t all = 0, one = 0;
  for (const Particle& particle : slam.particles())
    particle.map.for_each_node([&](const void* node, std::size_t bytes) {
      if (nodes.insert(node).second) all += bytes;
    });
  slam.particles()[0].map.for_each_node([&](const void*, std::size_t bytes) { one += bytes; });
  state.counters["MB_all_maps"] = 1e-6 * static_cast<double>(all);
  state.counters["MB_one_map"] = 1e-6 * static_cast<double>(one);
}

// Steps are made beforehand: only the filter is timed.
void run_steps(benchmark::State& state, FastSlam& slam, Wall& wall) {
  std::vector<SceneStep> steps;
  std::size_t i = 0;
  double resampled = 0, used = 0;
  for (auto _ : state) {
    if (i == steps.size()) {
      state.PauseTiming();
      steps.clear();
      for (int k = 0; k < 64; ++k) steps.push_back(wall.next(1));
      i = 0;
      state.ResumeTiming();
    }
    const StepResult r = slam.step(steps[i].motion, steps[i].frame);
    resampled += r.resampled;
    used += r.used;
    ++i;
  }
  state.counters["used"] = benchmark::Counter(used, benchmark::Counter::kAvgIterations);
  state.counters["resampled"] = benchmark::Counter(resampled, benchmark::Counter::kAvgIterations);
  state.counters["landmarks"] = slam.index().size();
  report_memory(state, slam);
}

void filter(benchmark::State& state) {
  cv::setNumThreads(1);
  FastSlamSettings settings;
  settings.planar = state.range(1) == 3;
  Wall wall(static_cast<int>(state.range(0)), 10);
  FastSlam slam = mapped(wall, settings, 10);
  run_steps(state, slam, wall);
}
BENCHMARK(filter)
    ->ArgsProduct({{35, 1000, 10000, 50000}, {3, 6}})
    ->ArgNames({"landmarks", "dof"})
    ->Unit(benchmark::kMillisecond);

void filter_1000_particles(benchmark::State& state) {
  cv::setNumThreads(static_cast<int>(state.range(0)));
  FastSlamSettings settings;
  settings.particles = 1000;
  Wall wall(10000, 100);
  FastSlam slam = mapped(wall, settings, 100);
  run_steps(state, slam, wall);
}
BENCHMARK(filter_1000_particles)
    ->Arg(1)
    ->Arg(2)
    ->ArgName("threads")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

// The scenes that compare_mrpt.sh made with MRPT's simul-landmarks, seen with the noise that it was given
// there.
void mrpt_scene(benchmark::State& state) {
  const char* folder = std::getenv("LCMSLAM_MRPT_SCENES");
  if (!folder) return state.SkipWithError("run tests/bench/compare_mrpt.sh");
  cv::setNumThreads(1);
  FastSlamSettings settings;
  settings.planar = state.range(1) == 3;
  settings.maximum_range = 30;  // as the sensor there
  synthetic::MrptScene scene(std::string(folder) + "/" + std::to_string(state.range(0)) + "-868/scene.rawlog",
                             3600. / static_cast<double>(state.range(0)));
  if (scene.size() == 0) return state.SkipWithError("no scene in LCMSLAM_MRPT_SCENES");
  FastSlam slam(settings);
  for (std::size_t i = 0; i < 148; ++i) {  // two laps: the whole map
    const SceneStep step = scene.step(i);
    slam.step(step.motion, step.frame);
  }
  std::vector<SceneStep> steps;
  for (std::size_t i = 148; i < scene.size(); ++i) steps.push_back(scene.step(i));
  double seen = 0;
  const double begin = process_milliseconds();
  for (auto _ : state)
    for (const SceneStep& step : steps) seen += slam.step(step.motion, step.frame).offered;
  const double passed = static_cast<double>(steps.size()) * static_cast<double>(state.iterations());
  state.counters["ms_a_step"] = (process_milliseconds() - begin) / passed;
  state.counters["mapped"] = slam.index().size();
  state.counters["seen"] = seen / passed;
}
BENCHMARK(mrpt_scene)
    ->ArgsProduct({{35, 70, 150, 300}, {3, 6}})
    ->ArgNames({"landmarks", "dof"})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void whole_step(benchmark::State& state) {
  cv::setNumThreads(1);
  FastSlam slam((FastSlamSettings()));
  Building building(4, 3, static_cast<int>(state.range(0)), 500, 3);
  int driven = 0;
  for (; slam.index().size() < state.range(1) && driven < 2000; ++driven) {
    const SceneStep step = building.next();
    slam.step(step.motion, step.frame);
  }
  std::vector<double> milliseconds;
  double used = 0, matched = 0, offered = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const SceneStep step = building.next();
    state.ResumeTiming();
    const double begin = process_milliseconds();
    const StepResult r = slam.step(step.motion, step.frame);
    benchmark::DoNotOptimize(slam.take_changes());
    milliseconds.push_back(process_milliseconds() - begin);
    used += r.used;
    matched += r.matched;
    offered += r.offered;
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  state.counters["p50_ms"] = milliseconds[milliseconds.size() / 2];
  state.counters["p95_ms"] = milliseconds[milliseconds.size() * 95 / 100];
  state.counters["max_ms"] = milliseconds.back();
  state.counters["landmarks"] = slam.index().size();
  report_memory(state, slam);
  state.counters["offered"] = benchmark::Counter(offered, benchmark::Counter::kAvgIterations);
  state.counters["matched"] = benchmark::Counter(matched, benchmark::Counter::kAvgIterations);
  state.counters["used"] = benchmark::Counter(used, benchmark::Counter::kAvgIterations);
}
BENCHMARK(whole_step)
    ->Args({1700, 20000})
    ->Args({7500, 20000})
    ->ArgNames({"a_room", "landmarks"})
    ->Iterations(240)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
