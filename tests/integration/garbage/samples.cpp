#include "tests/integration/garbage/samples.hpp"

#include <algorithm>
#include <deque>

#include <lcmslam/command_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/pose_t.hpp>
#include "procs/camera/publish_event.hpp"
#include "procs/fastslam/fastslam_node.hpp"
#include "procs/icp/icp_node.hpp"
#include "procs/odometry/odometry_node.hpp"
#include "procs/surf/surf_node.hpp"
#include "tests/integration/support/environment.hpp"

namespace lcmslam::integration {
namespace {

class Tape : public Publisher {
 public:
  Tape() : Publisher(1) {}
  std::deque<Sample> fresh;

 private:
  void send(const std::string& channel, const Bytes& bytes, Utime) override {
    fresh.push_back({channel, bytes});
  }
};

/// The processing nodes, with the tape for a bus.
class Graph {
 public:
  explicit Graph(Tape& tape)
      : tape_(tape),
        surf_(ConfigNode(), tape),
        odometry_(ConfigNode(), tape),
        fastslam_(ConfigNode(), tape),
        icp_(ConfigNode(), tape) {
    surf_.connect(inputs_[0]);
    odometry_.connect(inputs_[1]);
    fastslam_.connect(inputs_[2]);
    icp_.connect(inputs_[3]);
  }

  /// Delivers what is fresh until nothing is, and keeps all of it.
  void run(std::vector<Sample>& samples) {
    while (!tape_.fresh.empty()) {
      const Sample sample = std::move(tape_.fresh.front());
      tape_.fresh.pop_front();
      for (Inputs& inputs : inputs_) inputs.deliver(sample.channel, sample.bytes.data(), sample.bytes.size());
      samples.push_back(sample);
    }
  }
  void finish() {
    fastslam_.finish();
    icp_.finish();
  }

 private:
  Tape& tape_;
  SurfNode surf_;
  OdometryNode odometry_;
  FastSlamNode fastslam_;
  IcpNode icp_;
  Inputs inputs_[4];
};

/// What no node of the graph makes by itself.
void publish_requests(Tape& tape, Utime utime) {
  command_t command;
  command.utime = utime;
  command.target = "nobody";
  command.name = "nothing";
  command.n = 1;
  command.keys = {"key"};
  command.values = {"value"};
  tape.publish("COMMAND", command);

  map_request_t request;
  request.utime = utime;
  request.request_id = 7;
  request.kind = map_request_t::INFO;
  request.n_numbers = 2;
  request.numbers = {1, 2};
  tape.publish("MAP_REQUEST", request);

  status_t status;
  status.utime = utime;
  status.process = "nobody";
  status.pid = 1;
  status.state = status_t::RUNNING;
  status.uptime = status.cpu = status.cpu_total = status.latency_p50 = status.latency_p95 = 0;
  status.memory = status.kernel_drops = status.receive_buffer = 0;
  status.n_inputs = status.n_outputs = status.n_values = 0;
  tape.publish("STATUS", status);

  pose_t pose;
  pose.utime = utime;
  for (auto* values : {pose.pos, pose.vel, pose.rotation_rate, pose.accel}) std::fill_n(values, 3, 0.0);
  std::fill_n(pose.orientation, 4, 0.5);
  tape.publish("POSE_BODY", pose);
}

}  // namespace

Sample later(Sample sample, Utime us) {
  if (sample.channel == "CAMERA") {
    auto m = decode_message<images_t>(sample.bytes.data(), sample.bytes.size());
    m.utime += us;
    for (image_t& image : m.images) image.utime += us;
    return {sample.channel, encode_message(m)};
  }
  constexpr std::size_t begin = 8;  // behind the fingerprint, big-endian
  std::uint64_t utime = 0;
  for (std::size_t i = 0; i < 8; ++i) utime = (utime << 8) | sample.bytes.at(begin + i);
  utime += static_cast<std::uint64_t>(us);
  for (std::size_t i = 8; i-- > 0; utime >>= 8) sample.bytes[begin + i] = static_cast<std::uint8_t>(utime);
  return sample;
}

std::vector<Sample> record_samples(double seconds) {
  SimulationSourceSettings settings;
  settings.simulation.scene = source_folder() / "config/scenes/kitchen.yaml";
  settings.simulation.seconds = seconds;
  const auto source = make_simulation_source(settings);
  Tape tape;
  Graph graph(tape);
  std::vector<Sample> samples;
  camera_calibration_t calibration = to_message(source->calibration());
  calibration.utime = 0;
  tape.publish("CAMERA_CALIBRATION", calibration);
  Utime utime = 0;
  while (const auto event = source->next()) {
    utime = event_utime(*event);
    publish_event(tape, *event);
    graph.run(samples);
  }
  graph.finish();
  publish_requests(tape, utime);
  graph.run(samples);
  return samples;
}

}  // namespace lcmslam::integration
