// What it costs to keep a keyframe: its cloud as a blob of the map's file, beside the same points as messages
// carry them (12 bytes each), deflated as they stand; and a commit of one keyframe with its graph moved.
//
//   build/release/bin/bench_store --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
//
// `bytes` is the blob's size a point. The recording is tum_fr1_rpy.

#include <benchmark/benchmark.h>
#include <libdeflate.h>

#include <filesystem>

#include <lcmslam/map_store/file/map_store.hpp>
#include <lcmslam/map_store/file/store_codecs.hpp>
#include "tests/support/recorded_clouds.hpp"

namespace lcmslam {
namespace {

/// Some 19,000 points with normals, in whole millimetres as they arrive.
const ColouredCloud* recorded() {
  static const std::optional<ColouredCloud> cloud = []() -> std::optional<ColouredCloud> {
    const auto recording = Fr1Recording::open();
    if (!recording) return std::nullopt;
    ColouredCloud c = recording->cloud(0);
    for (Eigen::Vector3f& point : c.points) point = (point * 1000).array().round() / 1000;
    return c;
  }();
  return cloud ? &*cloud : nullptr;
}

void count(benchmark::State& state, std::size_t bytes) {
  state.counters["bytes"] = static_cast<double>(bytes) / static_cast<double>(recorded()->size());
}

void encode(benchmark::State& state) {
  if (recorded() == nullptr) return state.SkipWithError("the recording is not there");
  Blob blob;
  for (auto _ : state) benchmark::DoNotOptimize(blob = encode_cloud(*recorded()));
  count(state, blob.size());
}

void decode(benchmark::State& state) {
  if (recorded() == nullptr) return state.SkipWithError("the recording is not there");
  const Blob blob = encode_cloud(*recorded());
  for (auto _ : state) benchmark::DoNotOptimize(decode_cloud(blob));
}

/// The peer: x y z of 16 bits, three bytes of colour, three of the normal, point after point.
void deflate_rows(benchmark::State& state) {
  if (recorded() == nullptr) return state.SkipWithError("the recording is not there");
  std::vector<std::uint8_t> rows;
  for (std::size_t i = 0; i < recorded()->size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto units = static_cast<std::uint16_t>(std::lround(1000 * recorded()->points[i](axis)));
      rows.push_back(static_cast<std::uint8_t>(units));
      rows.push_back(static_cast<std::uint8_t>(units >> 8));
    }
    for (int channel = 0; channel < 3; ++channel) rows.push_back(recorded()->colours[i][channel]);
    for (int axis = 0; axis < 3; ++axis)
      rows.push_back(static_cast<std::uint8_t>(static_cast<int>(127 * recorded()->normals[i](axis))));
  }
  libdeflate_compressor* deflate = libdeflate_alloc_compressor(static_cast<int>(state.range(0)));
  std::vector<std::uint8_t> packed(libdeflate_deflate_compress_bound(deflate, rows.size()));
  std::size_t size = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(
        size = libdeflate_deflate_compress(deflate, rows.data(), rows.size(), packed.data(), packed.size()));
  libdeflate_free_compressor(deflate);
  count(state, size);
}

/// Of a keyframe, of as many moved ones as the map has, and of a hundred landmarks.
void commit(benchmark::State& state) {
  if (recorded() == nullptr) return state.SkipWithError("the recording is not there");
  const auto folder = std::filesystem::temp_directory_path() / "lcmslam-bench-store";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  {
    MapStore store(folder / "map.lcmslam");
    const std::int64_t session = store.add_session(store.add_run({"", ""}), {0, "icp", 1, "map"});
    std::int32_t id = 0;
    for (auto _ : state) {
      SessionChanges changes;
      changes.put_keyframe({id++, 0, Eigen::Isometry3d::Identity(), *recorded(), 1}, std::nullopt);
      for (int moved = 0; moved < state.range(0); ++moved)
        changes.move_keyframe(moved, 0, Eigen::Isometry3d::Identity());
      for (int i = 0; i < 100; ++i) {
        Landmark landmark;
        landmark.id = i;
        changes.put_landmark(landmark);
      }
      Transaction transaction = store.begin();
      store.write(session, changes);
      transaction.commit();
    }
  }
  std::filesystem::remove_all(folder);
}

BENCHMARK(encode)->Unit(benchmark::kMillisecond);
BENCHMARK(deflate_rows)->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);
BENCHMARK(decode)->Unit(benchmark::kMillisecond);
BENCHMARK(commit)->Arg(30)->Arg(1000)->Unit(benchmark::kMillisecond)->Iterations(50);

}  // namespace
}  // namespace lcmslam
