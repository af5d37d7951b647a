// What admitting loops costs when many wait: a building whose corridors look alike, each for its neighbour.
//   build/release/bin/bench_pose_graph
// Arguments: nodes, loops that wait. With a search for each pair of loops 100 that wait took 4 s and 200
// 17 s; with one from each end of a loop 0.06 and 0.14 s.

#include <benchmark/benchmark.h>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/pose_graph/loop_admission.hpp>

namespace lcmslam {
namespace {

/// Errors of 1 cm and 5 mrad, each edge its own.
UncertainTransform measured(const Eigen::Isometry3d& T, Random& random) {
  constexpr double sigma_t = 0.01, sigma_r = 0.005;
  Vector6d error;
  Matrix6d covariance = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? sigma_t : sigma_r;
    error(i) = sigma * random.normal();
    covariance(i, i) = sigma * sigma;
  }
  return {T * se3_exp(error), covariance};
}

void admits_loops_that_contradict_each_other(benchmark::State& state) {
  const auto nodes = static_cast<int>(state.range(0)), count = static_cast<int>(state.range(1));
  Random random(1);
  PoseGraph graph;
  graph.poses.emplace_back(Eigen::Isometry3d::Identity());
  const Eigen::Isometry3d ahead(Eigen::Translation3d(0.5, 0, 0));
  for (int i = 1; i < nodes; ++i) {
    graph.edges.push_back({i - 1, i, EdgeKind::registration, measured(ahead, random)});
    graph.poses.push_back(graph.poses.back() * graph.edges.back().T_from_to.T);
  }
  std::vector<GraphEdge> loops;
  for (int i = 0; i < count; ++i) {
    const Eigen::Isometry3d wrong(Eigen::Translation3d(20 * random.normal(), 20 * random.normal(), 0));
    loops.push_back({i, nodes - count + i, EdgeKind::loop, measured(wrong, random)});
  }
  for (auto _ : state) {
    std::vector<GraphEdge> waiting = loops;
    benchmark::DoNotOptimize(admit(waiting, graph, {}));
    state.counters["waiting"] = static_cast<double>(waiting.size());
  }
}
BENCHMARK(admits_loops_that_contradict_each_other)
    ->Args({600, 10})
    ->Args({600, 100})
    ->Args({600, 200})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
