#include "tools/doctor/graph_traffic.hpp"

#include <algorithm>
#include <optional>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/evaluation/median.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/rgbd/plausibility.hpp>
#include <lcmslam/runtime/launch_settings.hpp>
#include <lcmslam/runtime/options.hpp>
#include "procs/camera/camera_source.hpp"
#include "procs/camera/publish_event.hpp"

namespace lcmslam {
namespace {

constexpr std::size_t images = 4;
constexpr double slowest = 1, fastest = 200;  // Hz

/// Sends nothing: the base class counts the bytes, and the images are looked at.
class Scales : public Publisher {
 public:
  explicit Scales(const RgbdCalibration& calibration)
      : Publisher(0), calibration_(calibration), plausibility_(calibration) {}

  const Plausibility& plausibility() const { return plausibility_; }

 private:
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime) override {
    if (channel == "CAMERA")
      plausibility_.add(decode_images(decode_message<images_t>(bytes.data(), bytes.size()), calibration_));
  }

  const RgbdCalibration& calibration_;
  Plausibility plausibility_;
};

/// By the median of the intervals: a recording may have a gap, or stamps that leap. None where they do not go
/// on.
std::optional<double> rate_of(const std::vector<Utime>& times) {
  std::vector<double> intervals;  // us
  for (std::size_t i = 1; i < times.size(); ++i)
    intervals.push_back(static_cast<double>(times[i] - times[i - 1]));
  if (intervals.empty()) return std::nullopt;
  const double interval = median(std::move(intervals));
  if (interval <= 0) return std::nullopt;
  return 1e6 / interval;
}

bool has_camera(const ConfigNode& config) {
  const auto processes = read_settings<LaunchSettings>(config.section("launch")).processes;
  return std::find(processes.begin(), processes.end(), "camera") != processes.end();
}

/// A preset alone starts nothing that has images: what is missing is named as the user would write it.
void check_source(const ConfigNode& config, const std::string& file) {
  const ConfigNode camera = config.section("camera");
  if (camera.has("source") || camera.has("simulation")) return;  // the simulation is the default
  throw ConfigError(file +
                    ": names no camera.source, so nothing says where its images come from (a preset "
                    "is for a graph to include); where another driver sends them, launch.processes lists "
                    "the processes without 'camera'. lcmslam config --check " +
                    file + " reads all the rest");
}

}  // namespace

GraphTraffic graph_traffic(const std::string& config_file, const std::vector<std::string>& overrides) {
  const ConfigNode given = load_config(config_file, overrides);
  if (has_camera(given)) check_source(given, config_file);
  auto live = overrides;
  live.push_back("camera.simulation.render=live");  // a whole drive need not be rendered for three images
  const ConfigNode config = load_config(config_file, live);
  GraphTraffic traffic;
  if (!has_camera(config)) return traffic;

  const CameraSettings camera = read_camera_settings(config.section("camera"));
  if (camera.is_live_kind()) return traffic;  // the graph may hold the camera
  const auto source = make_camera_source(camera);
  Scales scales(source->calibration());
  std::vector<Utime> times;
  while (times.size() < images) {
    const auto event = source->next();
    if (!event) break;
    if (std::holds_alternative<EncodedFrame>(*event)) times.push_back(event_utime(*event));
    publish_event(scales, *event);
  }
  if (times.empty()) return traffic;
  traffic.depths = scales.plausibility().depths().in_words();
  traffic.doubts = scales.plausibility().findings();
  const auto largest = static_cast<std::size_t>(scales.counts().at("CAMERA").largest);
  traffic.largest = largest + largest / 2;
  if (const auto rate = rate_of(times)) traffic.rate = std::clamp(*rate * camera.speed, slowest, fastest);
  traffic.origin = "measured: images of " + std::to_string(largest / 1000) + " kB, and half as much again";
  return traffic;
}

}  // namespace lcmslam
