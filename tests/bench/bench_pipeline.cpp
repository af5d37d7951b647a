// What one frame costs in each part of the graph, on the simulated kitchen (ToF head), one thread.
//   build/release/bin/bench_pipeline --benchmark_repetitions=10 --benchmark_report_aggregates_only=true

#include <benchmark/benchmark.h>

#include <opencv2/imgproc.hpp>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/fastslam/fastslam.hpp>
#include <lcmslam/imaging/depth_filter.hpp>
#include <lcmslam/imaging/depth_registration.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/rgbd/describe_frame.hpp>
#include <lcmslam/rgbd/make_cloud.hpp>
#include <lcmslam/simulation/simulation.hpp>
#include <lcmslam/surf/surf.hpp>
#include "tests/support/source_folder.hpp"
#include "tests/unit/surf/dlib_surf.hpp"

namespace lcmslam {
namespace {

const Simulation& kitchen() {
  static const Simulation simulation({source_folder() / "config/scenes/kitchen.yaml"});
  return simulation;
}

Utime frame_time(int i) {
  return kitchen().start() + 1'000'000 + 100'000 * i;
}

const std::vector<RgbdFrame>& frames() {
  static const std::vector<RgbdFrame> rendered = [] {
    std::vector<RgbdFrame> all;
    for (int i = 0; i < 20; ++i) all.push_back(kitchen().render(frame_time(i)));
    return all;
  }();
  return rendered;
}

cv::Mat grey(const RgbdFrame& frame) {
  cv::Mat image;
  cv::cvtColor(frame.colour, image, cv::COLOR_BGR2GRAY);
  return image;
}

FeatureFrame features(const RgbdFrame& frame, Utime utime) {
  const RgbdCalibration& c = kitchen().calibration();
  Surf surf;
  FeatureFrame result = describe_frame(frame, register_depth(frame, c), c, surf);
  result.utime = utime;
  return result;
}

Motion true_motion(Utime from, Utime to) {
  Motion motion;
  motion.T_from_to = kitchen().T_world_robot(from).inverse() * kitchen().T_world_robot(to);
  motion.covariance = 1e-6 * Matrix6d::Identity();
  return motion;
}

void surf_detect_and_describe(benchmark::State& state) {
  cv::setNumThreads(1);
  frames();  // rendered before the clock runs
  Surf surf;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  std::size_t i = 0;
  double found = 0;
  for (auto _ : state) {
    surf.detectAndCompute(grey(frames()[i++ % frames().size()]), cv::noArray(), keypoints, descriptors);
    found += static_cast<double>(keypoints.size());
  }
  state.counters["keypoints"] = benchmark::Counter(found, benchmark::Counter::kAvgIterations);
}
BENCHMARK(surf_detect_and_describe)->Unit(benchmark::kMillisecond);

#ifdef LCMSLAM_HAS_DLIB
void surf_of_dlib(benchmark::State& state) {
  frames();
  std::size_t i = 0;
  double found = 0;
  for (auto _ : state) {
    const cv::Mat image = grey(frames()[i++ % frames().size()]);
    found +=
        static_cast<double>(dlib::get_surf_points(dlib::cv_image<unsigned char>(image), 600, 1.0).size());
  }
  state.counters["keypoints"] = benchmark::Counter(found, benchmark::Counter::kAvgIterations);
}
BENCHMARK(surf_of_dlib)->Unit(benchmark::kMillisecond);
#endif

void render(benchmark::State& state) {
  int i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(kitchen().render(frame_time(i++ % 200)));
}
BENCHMARK(render)->Unit(benchmark::kMillisecond);

void icp_step(benchmark::State& state) {
  const RgbdCalibration& c = kitchen().calibration();
  const DepthRegistration registration(c);
  DepthFilter filter(c);
  frames();
  DenseMapper mapper;
  Utime last = frame_time(0);
  int i = 0;
  for (auto _ : state) {
    const auto index = static_cast<std::size_t>(i++ % static_cast<int>(frames().size()));
    const Utime now = frame_time(static_cast<int>(index));
    RgbdFrame frame = frames()[index];
    frame.depth = frame.depth.clone();
    filter(frame.depth, frame.amplitude);
    mapper.step(coloured_frame(now, make_cloud(frame, registration(frame)), c.T_robot_camera,
                               true_motion(last, now)));
    last = now;
  }
}
BENCHMARK(icp_step)->Unit(benchmark::kMillisecond);

void fastslam_step(benchmark::State& state) {
  std::vector<FeatureFrame> all;
  for (std::size_t i = 0; i < frames().size(); ++i)
    all.push_back(features(frames()[i], frame_time(static_cast<int>(i))));
  FastSlam slam({});
  std::size_t i = 0;
  Utime last = frame_time(0);
  for (auto _ : state) {
    const FeatureFrame& frame = all[i++ % all.size()];
    slam.step(true_motion(last, frame.utime), frame);
    last = frame.utime;
  }
}
BENCHMARK(fastslam_step)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
