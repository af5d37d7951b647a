#include "batch/batch_run.hpp"

#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "log/log_reader.hpp"
#include "log/log_writer.hpp"
#include "messages/decode.hpp"
#include "messages/parts.hpp"
#include "runtime/options.hpp"

namespace lcmslam {
namespace {

/// The processes of section `launch`, without the camera: the log stands in its place.
std::vector<std::string> processes(const ConfigNode& config) {
  const ConfigNode launch = config.section("launch");
  auto names = launch.get("processes", process_names());
  launch.get("restart", true);
  config.ignore("camera");
  names.erase(std::remove(names.begin(), names.end(), "camera"), names.end());
  return names;
}

/// The log's messages, those in pieces put together.
class LogInputs {
 public:
  explicit LogInputs(const std::string& file) : reader_(file) {}

  std::optional<LogEvent> next() {
    while (auto event = reader_.next()) {
      ++events_;
      if (!is_part_channel(event->channel)) return event;
      try {
        const auto part = decode_message<part_t>(event->data.data(), event->data.size());
        if (auto whole = assembler_.add(part))
          return LogEvent{event->number, event->timestamp, whole->channel, std::move(whole->bytes)};
      } catch (const DecodeError&) {
        ++bad_parts_;
      }
    }
    return std::nullopt;
  }

  double share() const {
    return static_cast<double>(reader_.position()) / static_cast<double>(reader_.size());
  }
  std::int64_t events() const { return events_; }
  std::int64_t incomplete() const { return assembler_.incomplete() + bad_parts_; }
  std::size_t damages() const { return reader_.damages().size(); }

 private:
  LogReader reader_;
  PartAssembler assembler_;
  std::int64_t events_ = 0, bad_parts_ = 0;
};

}  // namespace

BatchResult run_batch(const BatchOptions& options) {
  BatchResult result;
  std::filesystem::create_directories(options.folder);
  result.output = options.folder / "batch.lcmlog";
  LogInputs inputs(options.log.string());
  LogWriter output(result.output.string());
  ConfigNode config = options.config;
  config.set("map-server.folder", options.folder.string());
  cv::setNumThreads(options.threads);

  Utime now = 0;
  BatchGraph graph(config, processes(config), options.threads,
                   [&](const BatchMessage& message) { output.write(now, message.channel, message.bytes); });
  config.finish();

  std::optional<Utime> start;
  std::optional<BatchMessage> calibration;  // the last one before `from`
  while (auto event = inputs.next()) {
    if (!start) start = event->timestamp;
    const double seconds = 1e-6 * static_cast<double>(event->timestamp - *start);
    if (options.to > 0 && seconds > options.to) break;
    if (!graph.is_input(event->channel)) continue;
    BatchMessage message{event->channel, std::move(event->data), event->timestamp};
    if (seconds < options.from) {
      if (message.channel == "CAMERA_CALIBRATION") calibration = std::move(message);
      continue;
    }
    now = std::max(now, event->timestamp);
    if (calibration) graph.deliver(*std::exchange(calibration, std::nullopt));
    ++result.delivered;
    result.frames += message.channel == "CAMERA" ? 1 : 0;
    result.log_seconds = seconds - options.from;
    graph.deliver(std::move(message));
    if (options.progress) options.progress(inputs.share(), result.log_seconds);
  }
  graph.finish();
  result.published = output.events();
  output.close();
  result.events = inputs.events();
  result.incomplete = inputs.incomplete();
  result.damages = inputs.damages();
  result.processes = graph.summary();
  return result;
}

}  // namespace lcmslam
