// Matching beside its peers on recorded descriptors, one thread. Needs ../shared/data (or $LCMSLAM_DATA).
//   build/release/bin/bench_matching --benchmark_repetitions=5 --benchmark_report_aggregates_only=true
// Look at the CPU column: the machine may be shared.
//
// Frame to frame: 1000 features of two frames 5 images apart. Frame to map: 500 features of frames that
// the map has not seen against 20,000 landmarks merged from the others; `both` is the share of queries
// whose nearest and second nearest were found, `nearest` of those whose nearest was.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <flann/flann.hpp>  // before OpenCV's: the other order breaks its serialisation
#include <opencv2/features2d.hpp>

#include <lcmslam/features/guided_matching.hpp>
#include <lcmslam/features/matching.hpp>
#include <lcmslam/features/rigid_ransac.hpp>
#include <lcmslam/geometry/random.hpp>
#include "tests/bench/cpu_time.hpp"
#include "tests/support/recorded_features.hpp"
#include "tests/support/recordings.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t map_size = 20'000, queries_a_frame = 500;

struct Recorded {
  std::vector<Feature> a, b;  // of two frames
  std::vector<Feature> map;
  std::vector<std::vector<Feature>> queries;
  std::vector<std::vector<Neighbours>> exact;

  Recorded() {
    cv::setNumThreads(1);
    auto frames = recorded_features(recording_path("livingroom1/image"), 5);
    const std::size_t first = frames.size();
    for (auto& frame : recorded_features(recording_path("tum_fr1_rpy/rgb"), 5)) frames.push_back(frame);
    if (first == 0 || frames.size() < first + 100) return;
    a = frames[first + 20];
    b = frames[first + 21];
    map = merged_map(frames, map_size);
    queries = unseen_queries(frames, 7, queries_a_frame);
    DescriptorIndex index;
    for (std::size_t i = 0; i < map.size(); ++i)
      index.insert(static_cast<int>(i), map[i].descriptor, map[i].laplacian);
    DescriptorSearch search({1, 1});
    for (const auto& features : queries) exact.push_back(search.nearest(features, index));
    std::printf("%zu and %zu features to match; a map of %zu; %zu frames of %zu queries\n", a.size(),
                b.size(), map.size(), queries.size(), queries_a_frame);
  }
};

// Nothing to measure without the recordings.
const Recorded* recorded(benchmark::State& state) {
  static const Recorded data;
  if (data.map.size() == map_size) return &data;
  state.SkipWithError("needs tum_fr1_rpy and livingroom1 in ../shared/data");
  return nullptr;
}

cv::Mat rows(const std::vector<Feature>& features) {
  cv::Mat result(static_cast<int>(features.size()), 64, CV_32F);
  for (int i = 0; i < result.rows; ++i)
    for (int k = 0; k < 64; ++k)
      result.at<float>(i, k) = features[static_cast<std::size_t>(i)].descriptor[static_cast<std::size_t>(k)];
  return result;
}

InstructionSet instruction_set(benchmark::State& state) {
  static const char* const names[] = {"portable", "sse2", "avx2"};
  const auto set = static_cast<InstructionSet>(state.range(0));
  state.SetLabel(names[state.range(0)]);
  if (!has(set)) state.SkipWithError("not on this processor");
  return has(set) ? set : InstructionSet::portable;
}

void frame_to_frame(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  Matcher matcher(instruction_set(state));
  const MatchingSettings settings{0.8, state.range(1) != 0};
  std::size_t found = 0;
  for (auto _ : state) found = matcher.match(data->a, data->b, settings).size();
  state.counters["matches"] = static_cast<double>(found);
}
BENCHMARK(frame_to_frame)
    ->ArgsProduct({{0, 1, 2}, {1, 0}})
    ->ArgNames({"set", "same_sign"})
    ->Unit(benchmark::kMillisecond);

// Ratio and mutual by hand: OpenCV's cross check excludes the ratio. It knows no signs.
void frame_to_frame_opencv(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  const cv::Mat a = rows(data->a), b = rows(data->b);
  const cv::BFMatcher matcher(cv::NORM_L2);
  int found = 0;
  for (auto _ : state) {
    std::vector<std::vector<cv::DMatch>> forward, back;
    matcher.knnMatch(a, b, forward, 2);
    matcher.knnMatch(b, a, back, 1);
    found = 0;
    for (const auto& m : forward)
      found += m.size() == 2 && m[0].distance < 0.8f * m[1].distance &&
               back[static_cast<std::size_t>(m[0].trainIdx)][0].trainIdx == m[0].queryIdx;
  }
  state.counters["matches"] = found;
}
BENCHMARK(frame_to_frame_opencv)->Unit(benchmark::kMillisecond);

void frame_to_map(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  DescriptorIndex index;
  for (std::size_t i = 0; i < data->map.size(); ++i)
    index.insert(static_cast<int>(i), data->map[i].descriptor, data->map[i].laplacian);
  DescriptorSearch search({static_cast<double>(state.range(1)) / 100, 1}, instruction_set(state));
  std::size_t frame = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(search.nearest(data->queries[frame++ % data->queries.size()], index).data());
  Recall recall;
  for (std::size_t i = 0; i < data->queries.size(); ++i)
    recall.add(search.nearest(data->queries[i], index), data->exact[i]);
  state.counters["both"] = recall.of_both();
  state.counters["nearest"] = recall.of_nearest();
  state.counters["MB"] = static_cast<double>(index.memory_bytes()) / 1e6;
}
BENCHMARK(frame_to_map)
    ->ArgsProduct({{1, 2}, {5, 10, 15, 20, 100}})
    ->ArgNames({"set", "percent"})
    ->Unit(benchmark::kMillisecond);

void frame_to_map_match(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  DescriptorIndex index;
  for (std::size_t i = 0; i < data->map.size(); ++i)
    index.insert(static_cast<int>(i), data->map[i].descriptor, data->map[i].laplacian);
  DescriptorSearch search({}, instruction_set(state));
  std::size_t frame = 0, found = 0;
  for (auto _ : state) found += search.match(data->queries[frame++ % data->queries.size()], index).size();
  state.counters["matches"] =
      benchmark::Counter(static_cast<double>(found), benchmark::Counter::kAvgIterations);
}
BENCHMARK(frame_to_map_match)->Arg(1)->Arg(2)->ArgName("set")->Unit(benchmark::kMillisecond);

// A forest for each sign, as our index has lists for each.
struct Forest {
  cv::Mat values;
  std::vector<int> ids;
  flann::Index<flann::L2<float>> trees{flann::KDTreeIndexParams(4)};

  Forest(const std::vector<Feature>& map, bool dark) {
    std::vector<Feature> of_sign;
    for (std::size_t i = 0; i < map.size(); ++i) {
      if ((map[i].laplacian >= 0) != dark) continue;
      of_sign.push_back(map[i]);
      ids.push_back(static_cast<int>(i));
    }
    values = rows(of_sign);
  }
  flann::Matrix<float> part(std::size_t first, std::size_t count) {
    return {values.ptr<float>(static_cast<int>(first)), count, 64};
  }
};

void frame_to_map_flann(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  flann::seed_random(1);
  Forest forests[2] = {{data->map, false}, {data->map, true}};
  for (Forest& forest : forests) forest.trees.buildIndex(forest.part(0, forest.ids.size()));
  flann::SearchParams parameters(static_cast<int>(state.range(0)));
  std::vector<std::size_t> found(2 * queries_a_frame);
  std::vector<float> distances(2 * queries_a_frame);
  const auto search = [&](const std::vector<Feature>& queries, std::vector<Neighbours>& neighbours) {
    neighbours.assign(queries.size(), {});
    for (const bool dark : {false, true}) {
      std::vector<Feature> of_sign;
      std::vector<std::size_t> query;
      for (std::size_t i = 0; i < queries.size(); ++i)
        if ((queries[i].laplacian >= 0) == dark) {
          of_sign.push_back(queries[i]);
          query.push_back(i);
        }
      cv::Mat values = rows(of_sign);
      flann::Matrix<std::size_t> indices(found.data(), of_sign.size(), 2);
      flann::Matrix<float> squares(distances.data(), of_sign.size(), 2);
      forests[dark].trees.knnSearch(flann::Matrix<float>(values.ptr<float>(), of_sign.size(), 64), indices,
                                    squares, 2, parameters);
      for (std::size_t i = 0; i < of_sign.size(); ++i)
        for (std::size_t k = 0; k < 2; ++k)
          neighbours[query[i]][k] = {forests[dark].ids[indices[i][k]], static_cast<int>(squares[i][k])};
    }
  };
  std::vector<Neighbours> neighbours;
  std::size_t frame = 0;
  for (auto _ : state) search(data->queries[frame++ % data->queries.size()], neighbours);
  Recall recall;
  for (std::size_t i = 0; i < data->queries.size(); ++i) {
    search(data->queries[i], neighbours);
    recall.add(neighbours, data->exact[i]);
  }
  state.counters["both"] = recall.of_both();
  state.counters["nearest"] = recall.of_nearest();
  state.counters["MB"] = static_cast<double>(forests[0].trees.usedMemory() + forests[1].trees.usedMemory() +
                                             256 * static_cast<int>(map_size)) /
                         1e6;
}
BENCHMARK(frame_to_map_flann)
    ->Arg(128)
    ->Arg(256)
    ->Arg(512)
    ->Arg(1024)
    ->Arg(2048)
    ->ArgName("checks")
    ->Unit(benchmark::kMillisecond);

void report_batches(benchmark::State& state, std::vector<double>& milliseconds) {
  std::sort(milliseconds.begin(), milliseconds.end());
  state.counters["batch_p50_ms"] = milliseconds[milliseconds.size() / 2];
  state.counters["batch_p95_ms"] = milliseconds[milliseconds.size() * 95 / 100];
  state.counters["batch_max_ms"] = milliseconds.back();
}

// The whole growth from nothing to 20,000 in steps of 100 (one iteration); the counters are of the steps.
void growth(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  std::vector<double> batches;
  double slowest_insertion = 0;
  for (auto _ : state) {
    DescriptorIndex index;
    for (std::size_t first = 0; first < map_size; first += 100) {
      const double start = cpu_milliseconds();
      double last = start;
      for (std::size_t i = first; i < first + 100; ++i) {
        index.insert(static_cast<int>(i), data->map[i].descriptor, data->map[i].laplacian);
        const double now = cpu_milliseconds();
        slowest_insertion = std::max(slowest_insertion, now - last);
        last = now;
      }
      batches.push_back(last - start);
    }
  }
  report_batches(state, batches);
  state.counters["insertion_max_ms"] = slowest_insertion;
}
BENCHMARK(growth)->Unit(benchmark::kMillisecond);

void growth_flann(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  std::vector<double> batches;
  for (auto _ : state) {
    flann::seed_random(1);
    Forest forests[2] = {{data->map, false}, {data->map, true}};
    std::size_t done[2] = {0, 0};
    for (int first = 0; first < static_cast<int>(map_size); first += 100) {
      const double start = cpu_milliseconds();
      for (int sign = 0; sign < 2; ++sign) {
        Forest& forest = forests[sign];
        const auto end = std::lower_bound(forest.ids.begin(), forest.ids.end(), first + 100);
        const auto next = static_cast<std::size_t>(end - forest.ids.begin());
        if (next == done[sign]) continue;
        const auto part = forest.part(done[sign], next - done[sign]);
        if (done[sign] == 0)
          forest.trees.buildIndex(part);
        else
          forest.trees.addPoints(part, 2);
        done[sign] = next;
      }
      batches.push_back(cpu_milliseconds() - start);
    }
  }
  report_batches(state, batches);
}
BENCHMARK(growth_flann)->Unit(benchmark::kMillisecond);

// 500 features against 20,000 landmarks that fill a hall, prediction good to 2 cm and 0.6 degrees.
void guided(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  Random random(1);
  FeatureFrame frame;
  frame.width = 640;
  frame.height = 480;
  frame.fx = frame.fy = 525;
  frame.cx = 319.5;
  frame.cy = 239.5;
  PredictedPose pose;
  pose.covariance.diagonal() << 4e-4, 4e-4, 4e-4, 1e-4, 1e-4, 1e-4;
  std::vector<MapPoint> landmarks;
  DescriptorIndex index;
  for (std::size_t i = 0; i < data->map.size(); ++i) {
    const Eigen::Vector3d position(random.uniform(-5, 5), random.uniform(-2, 2), random.uniform(-5, 5));
    landmarks.push_back({static_cast<int>(i), position, 1e-4 * Eigen::Matrix3d::Identity()});
    Feature feature = data->map[i];
    index.insert(landmarks.back().id, feature.descriptor, feature.laplacian);
    const auto projection = project(landmarks.back(), pose.T_world_camera, frame);
    if (!projection || frame.features.size() == queries_a_frame) continue;
    feature.x = static_cast<float>(projection->pixel.x() + 10 * random.normal());
    feature.y = static_cast<float>(projection->pixel.y() + 10 * random.normal());
    if (feature.x >= 0 && feature.y >= 0 && feature.x < 640 && feature.y < 480)
      frame.features.push_back(feature);
  }
  GuidedMatcher matcher;
  const GuidedResult* found = nullptr;
  for (auto _ : state) found = &matcher.match(frame, pose, landmarks, index);
  state.counters["in_view"] = found->in_view;
  state.counters["candidates"] = found->candidates;
  state.counters["matches"] = static_cast<double>(found->matches.size());
}
BENCHMARK(guided)->Unit(benchmark::kMillisecond);

// 150 pairs, as the sensor measures them.
void ransac(benchmark::State& state) {
  Random random(1);
  const Eigen::Isometry3d T_a_b = se3_exp(0.1 * Vector6d::Ones());
  const Eigen::Matrix3d covariance = Eigen::Vector3d(2.5e-5, 2.5e-5, 2e-4).asDiagonal();
  const Eigen::Vector3d sigma = covariance.diagonal().cwiseSqrt();
  const auto noise = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
  const auto point = [&] {
    return Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(1, 4));
  };
  std::vector<PointPair> pairs;
  for (int i = 0; i < 150; ++i) {
    const Eigen::Vector3d in_b = point();
    const bool outlier = 100 * i < 150 * state.range(0);
    pairs.push_back({(outlier ? point() : T_a_b * in_b) + sigma.cwiseProduct(noise()),
                     in_b + sigma.cwiseProduct(noise()), covariance, covariance});
  }
  std::uint64_t seed = 0;
  double successes = 0, hypotheses = 0;
  for (auto _ : state) {
    Random draw(++seed);
    const RigidRansacResult result = align_ransac(pairs, {}, draw);
    successes += result.success;
    hypotheses += result.iterations;
  }
  state.counters["success"] = benchmark::Counter(successes, benchmark::Counter::kAvgIterations);
  state.counters["hypotheses"] = benchmark::Counter(hypotheses, benchmark::Counter::kAvgIterations);
}
BENCHMARK(ransac)
    ->Arg(20)
    ->Arg(40)
    ->Arg(60)
    ->Arg(80)
    ->ArgName("outliers_percent")
    ->Unit(benchmark::kMillisecond);

// An observed landmark takes a new descriptor; a forgotten one leaves.
void update_100(benchmark::State& state) {
  const Recorded* data = recorded(state);
  if (!data) return;
  DescriptorIndex index;
  for (std::size_t i = 0; i < data->map.size(); ++i)
    index.insert(static_cast<int>(i), data->map[i].descriptor, data->map[i].laplacian);
  std::size_t next = 0;
  for (auto _ : state)
    for (int i = 0; i < 100; ++i, next += 37)
      index.update(static_cast<int>(next % map_size), data->map[(next + 1) % map_size].descriptor);
}
BENCHMARK(update_100)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
