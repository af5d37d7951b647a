#pragma once
// Both ends of a bridge and the broker between them: what a robot publishes, what an operator hears, and
// Debian's mosquitto.

#include <csignal>
#include <fstream>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <thread>

#include <lcmslam/images_t.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/runtime/lcm_bus.hpp>
#include "tests/integration/support/bus.hpp"
#include "tests/integration/support/environment.hpp"
#include "tests/integration/support/program.hpp"
#include "tests/integration/support/slow_link.hpp"

namespace lcmslam::integration {

inline Utime wall_clock() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// mosquitto on a port of its own.
class BrokerProgram {
 public:
  explicit BrokerProgram(const TemporaryFolder& folder, const std::string& more = "allow_anonymous true\n")
      : file_(folder / "mosquitto.conf") {
    std::ofstream(file_) << "listener " << port << " 127.0.0.1\nmax_queued_messages 100000\n" << more;
    start();
  }
  void start() { program_.emplace(std::vector<std::string>{find(), "-c", file_.string()}); }
  void kill_hard() {
    program_->send(SIGKILL);
    program_->wait(5);
  }
  std::string output() const { return program_->output(); }

  static std::string find() {
    for (const char* path : {"/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "/usr/bin/mosquitto"})
      if (std::filesystem::exists(path)) return path;
    return {};
  }
  const int port = free_port();

 private:
  std::filesystem::path file_;
  std::optional<Program> program_;
};

/// What a mapper publishes, to be compared bit for bit at the other end.
class Mapper {
 public:
  explicit Mapper(Bus& bus) : bus_(bus) {}

  void pose() {
    pose_estimate_t message{};
    message.utime = wall_clock();
    message.seq = poses_++;
    message.sender = 77;
    message.frame = "map";
    bus_.publish("FASTSLAM_POSE", message);
    bus_.publish("ICP_POSE", message);
  }
  /// What six processes say of themselves each second.
  void states() {
    status_t message{};
    message.seq = states_++;
    message.state = status_t::RUNNING;
    input_status_t input{};
    input.channel = "SOME_CHANNEL";
    message.inputs.assign(12, input);
    message.n_inputs = 12;
    for (int process = 0; process < 6; ++process) {
      message.utime = wall_clock();
      message.sender = 100 + process;
      message.process = "process-" + std::to_string(process);
      bus_.publish("STATUS", message);
    }
  }
  /// Colour and depth of a room with some texture.
  void picture(const std::string& channel = "CAMERA") {
    if (frame_.colour.bytes.empty()) {
      cv::Mat colour(480, 640, CV_8UC3), depth(480, 640, CV_16UC1);
      for (int v = 0; v < 480; ++v)
        for (int u = 0; u < 640; ++u) {
          colour.at<cv::Vec3b>(v, u) = cv::Vec3b(static_cast<unsigned char>(u * v / 100), 90, 200);
          depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(1000 + 3 * u + (u * 7 + v * 13) % 20);
        }
      frame_.colour = encode_colour(colour, 1, 90);
      frame_.depth = encode_depth(depth, 1);
      frame_.sensor = "head";
    }
    frame_.utime = frame_.colour.utime = frame_.depth.utime = wall_clock();
    images_t message = to_message(frame_);
    set_origin(message, {pictures_++, 77});
    bus_.publish(channel, message);
  }
  void keyframe(int points = 4000) {  // 10 bytes each
    keyframe_t message{};
    message.utime = wall_clock();
    message.seq = message.id = static_cast<std::int32_t>(keyframes.size());
    message.sender = 77;
    message.frame = "map";
    message.n_tiles = 1;
    message.n_values = 3 * points;
    for (int i = 0; i < message.n_values; ++i) {
      message.position.push_back(static_cast<std::int16_t>(i * 31 + message.id));
      message.colour.push_back(static_cast<std::uint8_t>(i));
      message.normal.push_back(1);
    }
    bus_.publish("ICP_KEYFRAME", encode_message(message));
    message.seq = 0;
    keyframes[message.id] = encode_message(message);
  }
  std::map<int, Bytes> keyframes;  // by id; without their numbers: the bridge at the other end counts anew

 private:
  Bus& bus_;
  std::int64_t poses_ = 0, states_ = 0, pictures_ = 0;
  EncodedFrame frame_;
};

/// Hears an operator's bus: the channels below a robot's name.
class Operator {
 public:
  Operator() : bus_(std::getenv("LCM_DEFAULT_URL")), thread_([this] { listen(); }) {}
  ~Operator() {
    stop_ = true;
    thread_.join();
  }
  Operator(const Operator&) = delete;
  Operator& operator=(const Operator&) = delete;

  std::map<int, Bytes> keyframes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return keyframes_;
  }
  /// s, of the poses of this channel that were measured between these times; ascending.
  std::vector<double> ages(const std::string& channel, Utime from, Utime to) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<double> ages;
    const auto found = poses_.find(channel);
    if (found != poses_.end())
      for (const auto& [utime, age] : found->second)
        if (utime >= from && utime < to) ages.push_back(age);
    std::sort(ages.begin(), ages.end());
    return ages;
  }
  /// Of the newest pose.
  Utime newest() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return newest_;
  }
  std::vector<images_t> pictures() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return pictures_;
  }

 private:
  void listen() {
    setenv("LCMSLAM_ROBOT", "mirror", 1);
    Inputs inputs;
    for (const std::string channel : {"FASTSLAM_POSE", "ICP_POSE"})
      inputs.subscribe<pose_estimate_t>(channel, 10'000, [this, channel](const pose_estimate_t& m) {
        const std::lock_guard<std::mutex> lock(mutex_);
        poses_[channel][m.utime] = 1e-6 * static_cast<double>(wall_clock() - m.utime);
        newest_ = std::max(newest_, m.utime);
      });
    inputs.subscribe<images_t>("CAMERA", 10'000, [this](const images_t& m) {
      const std::lock_guard<std::mutex> lock(mutex_);
      pictures_.push_back(m);
    });
    inputs.subscribe<keyframe_t>("ICP_KEYFRAME", 10'000, [this](keyframe_t m) {
      const std::lock_guard<std::mutex> lock(mutex_);
      m.seq = 0;
      keyframes_[m.id] = encode_message(m);
    });
    Receiver receiver(bus_, inputs);
    unsetenv("LCMSLAM_ROBOT");
    ready_ = true;
    Arrival arrival;
    while (!stop_)
      if (receiver.take(arrival, std::chrono::milliseconds(20))) arrival.deliver();
  }

 public:
  std::atomic<bool> ready_{false};

 private:
  LcmBus bus_;
  mutable std::mutex mutex_;
  std::map<std::string, std::map<Utime, double>> poses_;  // s, by channel and stamp
  std::vector<images_t> pictures_;
  Utime newest_ = 0;
  std::map<int, Bytes> keyframes_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace lcmslam::integration
