// Registration against PCL's on the same clouds: ten pairs of tum_fr1_rpy, five frames apart, voxels of 2 and
// 4 cm, from the identity. Everything after the voxel filter counts on both sides: normals, covariances,
// trees.
//   build/release/bin/bench_registration
// Counters: errors against motion capture (medians over the pairs), milliseconds of this thread (median and
// 95th percentile over pairs and repetitions), ratio = peer's median over ours.

#include <benchmark/benchmark.h>

#include <functional>

#include <lcmslam/registration/registration.hpp>
#include "tests/bench/cpu_time.hpp"
#include "tests/bench/pcl_peer.hpp"
#include "tests/support/recorded_clouds.hpp"

namespace lcmslam {
namespace {

constexpr int pairs_used = 10;
constexpr std::size_t apart = 5;

struct BenchPair {
  Cloud source, target;  // points alone
  PclPair pcl;
  Eigen::Isometry3d T_target_source;  // motion capture
};

std::vector<BenchPair> make_pairs(double voxel_size) {
  std::vector<BenchPair> pairs;
  const auto recording = Fr1Recording::open();
  if (!recording) return pairs;
  const auto points_of = [&](std::size_t i) {
    const Cloud cloud = voxel_filtered(geometry_of(recording->cloud(i, 2)), voxel_size);
    return Cloud(cloud.points);
  };
  const std::size_t first = 20, stride = (recording->size() - 2 * first - apart) / pairs_used;
  for (std::size_t k = 0; k < pairs_used; ++k) {
    const std::size_t i = first + k * stride;
    Cloud target = points_of(i), source = points_of(i + apart);
    PclPair pcl(source.points, target.points);
    pairs.push_back({std::move(source), std::move(target), std::move(pcl),
                     recording->T_world_camera(i).inverse() * recording->T_world_camera(i + apart)});
  }
  return pairs;
}

const std::vector<BenchPair>& pairs_at(int millimetres) {
  static std::map<int, std::vector<BenchPair>> made;
  if (made.count(millimetres) == 0) made[millimetres] = make_pairs(1e-3 * millimetres);
  return made[millimetres];
}

/// Milliseconds and errors of one method over all pairs.
class Score {
 public:
  void run(const BenchPair& pair, const std::function<Eigen::Isometry3d(const BenchPair&)>& method) {
    const double before = cpu_milliseconds();
    const Eigen::Isometry3d T = method(pair);
    times_.push_back(cpu_milliseconds() - before);
    const Eigen::Isometry3d error = pair.T_target_source.inverse() * T;
    metres_.push_back(error.translation().norm());
    degrees_.push_back(rotation_angle(error) * 180 / 3.14159265358979);
  }
  double time(double share) const { return quantile(times_, share); }
  void count(benchmark::State& state, const std::string& name) const {
    state.counters[name + "_ms"] = time(0.5);
    state.counters[name + "_ms_p95"] = time(0.95);
    state.counters[name + "_mm"] = 1e3 * quantile(metres_, 0.5);
    state.counters[name + "_mm_max"] = 1e3 * quantile(metres_, 1);
    state.counters[name + "_deg"] = quantile(degrees_, 0.5);
    state.counters[name + "_deg_max"] = quantile(degrees_, 1);
  }

 private:
  std::vector<double> times_, metres_, degrees_;
};

// Both in turn, so that what else the machine does falls on both.
void compare(benchmark::State& state, MetricKind metric,
             const std::function<Eigen::Isometry3d(const BenchPair&)>& peer) {
  const auto& pairs = pairs_at(static_cast<int>(state.range(0)));
  if (pairs.empty()) return state.SkipWithError("no ../shared/data/tum_fr1_rpy");
  const auto passes = wide_passes(metric);
  const auto ours = [&](const BenchPair& p) {
    return register_clouds(p.source, p.target, Eigen::Isometry3d::Identity(), passes).T_target_source;
  };
  Score our_score, peer_score;
  for (auto _ : state)
    for (const BenchPair& pair : pairs) {
      our_score.run(pair, ours);
      peer_score.run(pair, peer);
    }
  our_score.count(state, "a_ours");
  peer_score.count(state, "b_peer");
  state.counters["ratio"] = peer_score.time(0.5) / our_score.time(0.5);
}

void point_to_plane_against_pcl_icp(benchmark::State& state) {
  compare(state, MetricKind::point_to_plane, [](const BenchPair& p) { return p.pcl.icp({}); });
}
void gicp_against_pcl_gicp(benchmark::State& state) {
  compare(state, MetricKind::plane_to_plane, [](const BenchPair& p) { return p.pcl.gicp({}); });
}
BENCHMARK(point_to_plane_against_pcl_icp)->Arg(20)->Arg(40)->Iterations(3)->Unit(benchmark::kMillisecond);
BENCHMARK(gicp_against_pcl_gicp)->Arg(20)->Arg(40)->Iterations(3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
