// Does the price of a registration depend on the map's size? The same view against the map of a room and
// against one of two million voxels around it.
//
//   build/release/bin/bench_map --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>

#include <lcmslam/dense_mapper/dense_mapper.hpp>
#include <lcmslam/dense_mapper/voxel_map.hpp>
#include <lcmslam/registration/registration.hpp>
#include "tests/support/cloud_scenes.hpp"

namespace lcmslam {
namespace {

/// The room, and beside it floors of `hall` x `hall` m, 4 m apart, on `floors` levels.
const VoxelMap& map_of(int floors, double hall) {
  static std::map<int, VoxelMap> maps;
  const auto [found, fresh] = maps.try_emplace(floors, VoxelMapSettings{});
  if (!fresh) return found->second;
  for (int level = 0; level < floors; ++level) {
    Cloud cloud;
    add_rectangle(cloud, {-hall / 2, -hall / 2, -6.02 - 4 * level}, {hall, 0, 0}, {0, hall, 0}, 0.03);
    found->second.insert(cloud, Eigen::Isometry3d::Identity());
  }
  Cloud seen = room(0.03);
  found->second.insert(seen, Eigen::Isometry3d::Identity());
  return found->second;
}

void registers(benchmark::State& state) {
  const VoxelMap& map = map_of(static_cast<int>(state.range(0)), 40);
  const Cloud source = transformed(room(0.04), se3_exp(twist(0.03, -0.02, 0.02, 0.01, 0, 0.02)).inverse());
  const RegistrationSettings settings = DenseMapperSettings::fine_defaults();
  for (auto _ : state)
    benchmark::DoNotOptimize(register_cloud(source, map, Eigen::Isometry3d::Identity(), settings));
  state.counters["voxels"] = static_cast<double>(map.size());
  state.counters["MB"] = static_cast<double>(map.memory_bytes()) * 1e-6;
}
BENCHMARK(registers)->Arg(0)->Arg(1)->Arg(2)->Arg(3)->Unit(benchmark::kMillisecond);

// What a frame of 25,000 points pays for free space, in a room with 100 more points in the air that come
// back.
void looks_through(benchmark::State& state) {
  VoxelMap map = map_of(static_cast<int>(state.range(0)), 40);
  const Eigen::Isometry3d T_world_camera(optical_axes());
  Cloud image;
  for (int row = -72; row < 72; ++row)
    for (int column = -88; column < 88; ++column) {
      const Eigen::Vector3f ray(0.005f * static_cast<float>(column), 0.005f * static_cast<float>(row), 1);
      const Eigen::Vector3f world = T_world_camera.linear().cast<float>() * ray;
      float z = 3 / world.x();  // the wall ahead, and the floor
      if (world.z() < 0) z = std::min(z, -1 / world.z());
      image.points.emplace_back(z * ray);
      image.sigmas.push_back(0.005f);
    }
  Cloud ghost;
  add_rectangle(ghost, {1.8, -0.25, -0.5}, {0, 0, 0.5}, {0, 0.5, 0}, 0.05);
  const FreeSpaceSettings settings;
  std::int32_t turn = 0;
  std::size_t gone = 0;
  for (auto _ : state) {
    if (turn % 50 == 0) map.insert(ghost, Eigen::Isometry3d::Identity());
    gone += map.look_through(FreeSpaceView(image, settings), T_world_camera, settings, turn++).size();
  }
  state.counters["voxels"] = static_cast<double>(map.size());
  state.counters["gone"] = static_cast<double>(gone);
}
BENCHMARK(looks_through)->Arg(0)->Arg(3)->Unit(benchmark::kMillisecond);

void bends(benchmark::State& state) {
  const VoxelMap& map = map_of(static_cast<int>(state.range(0)), 40);
  const std::vector<Eigen::Isometry3d> moves = {se3_exp(twist(0.01, 0, 0, 0, 0, 0.001))};
  for (auto _ : state) benchmark::DoNotOptimize(map.deformed(moves).size());
  state.counters["voxels"] = static_cast<double>(map.size());
}
BENCHMARK(bends)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
