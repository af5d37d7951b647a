// What a frame of tum_fr1_rpy (VGA at 30 Hz) costs the process `icp`, from the bytes of CAMERA to ICP_POSE,
// with features and visual odometry as in the graph. CPU time of all threads, ms a frame: median, 95th and
// 99th percentile, worst; and the part that the pose waits for after its odometry has come.
//   build/release/bin/bench_mapper

#include <benchmark/benchmark.h>

#include <filesystem>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/runtime/machine.hpp>
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/bench/cpu_time.hpp"
#include "tests/support/recordings.hpp"
#include "tests/support/test_bus.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t frames_used = 300;

struct BenchMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// What `icp` hears for each frame: CAMERA, FEATURES, ODOMETRY. Empty without the recording.
const std::vector<std::vector<BenchMessage>>& recording() {
  static const std::vector<std::vector<BenchMessage>> frames = [] {
    std::vector<std::vector<BenchMessage>> all;
    const std::string folder = recording_path("tum_fr1_rpy");
    if (!std::filesystem::exists(folder)) return all;
    const auto source = open_dataset(folder);
    testing::TestBus front;
    front.add<SurfNode>();
    front.add<OdometryNode>(ConfigNode::parse("{source: visual}"));
    front.deliver("CAMERA_CALIBRATION", to_message(source->calibration()));
    for (std::size_t i = 0; i < std::min(frames_used, source->size()); ++i) {
      const auto frame = source->frame(i);
      if (!frame) continue;
      all.emplace_back();
      all.back().push_back({"CAMERA", encode_message(to_message(*frame))});
      const std::size_t before = front.published().size();
      front.deliver("CAMERA", all.back().front().bytes);
      for (std::size_t k = before; k < front.published().size(); ++k)
        all.back().push_back({front.published()[k].channel, front.published()[k].bytes});
    }
    return all;
  }();
  return frames;
}

void icp_frame(benchmark::State& state) {
  if (recording().empty()) return state.SkipWithError("no ../shared/data/tum_fr1_rpy");
  const auto source = open_dataset(recording_path("tum_fr1_rpy"));
  keep_freed_memory();  // as processes do
  std::vector<double> whole, after_odometry;
  for (auto _ : state) {
    testing::CapturingPublisher publisher(1);
    IcpNode node(ConfigNode{}, publisher);
    Inputs inputs;
    node.connect(inputs);
    const auto calibration = encode_message(to_message(source->calibration()));
    inputs.deliver("CAMERA_CALIBRATION", calibration.data(), calibration.size());
    for (const auto& frame : recording()) {
      const double process = cpu_milliseconds(CLOCK_PROCESS_CPUTIME_ID);
      double answer = 0;
      for (const BenchMessage& message : frame) {
        const double thread = cpu_milliseconds();
        inputs.deliver(message.channel, message.bytes.data(), message.bytes.size());
        if (message.channel == "ODOMETRY") answer = cpu_milliseconds() - thread;
      }
      node.work();
      whole.push_back(cpu_milliseconds(CLOCK_PROCESS_CPUTIME_ID) - process);
      after_odometry.push_back(answer);
    }
    node.finish();
  }
  for (const auto& [name, times] : {std::pair("frame", &whole), std::pair("after_odometry", &after_odometry)})
    for (const auto& [percentile, share] : {std::pair("50", 0.5), {"95", 0.95}, {"99", 0.99}, {"max", 1.0}})
      state.counters[std::string(name) + "_" + percentile] = quantile(*times, share);
}
BENCHMARK(icp_frame)->Iterations(3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lcmslam
