// What telling a change of a large graph takes: a mapper waits for it at each keyframe.

#include <benchmark/benchmark.h>

#include <lcmslam/messages/graph_teller.hpp>
#include "tests/unit/messages/graph_samples.hpp"

namespace {

using namespace lcmslam;

/// Each node is measured against eight before it, as a mapper finds them: the newest node's last.
graph_t large_graph(int nodes) {
  std::vector<graph_node_t> all;
  std::vector<graph_edge_t> edges;
  for (int i = 0; i < nodes; ++i) {
    all.push_back(testing::node(i, 0.1 * i));
    for (int k = 1; k <= 8 && i >= k * k; ++k) edges.push_back(testing::edge(i - k * k, i, k % 3));
  }
  return testing::graph_of(0, std::move(all), std::move(edges));
}

void tell_a_keyframe(benchmark::State& state) {
  const int nodes = static_cast<int>(state.range(0));
  const graph_t before = large_graph(nodes), after = large_graph(nodes + 1);
  GraphTeller teller;
  teller.tell(before, true);
  bool grown = false;
  for (auto _ : state) {
    state.PauseTiming();
    graph_t whole = (grown = !grown) ? after : before;
    state.ResumeTiming();
    benchmark::DoNotOptimize(teller.tell(std::move(whole), false));
  }
}
BENCHMARK(tell_a_keyframe)->Arg(600)->Arg(40'000)->Unit(benchmark::kMillisecond);

}  // namespace
