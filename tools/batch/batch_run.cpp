#include "tools/batch/batch_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <opencv2/core/utility.hpp>

#include <lcmslam/configuration/read_settings.hpp>
#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/log/log_session.hpp"
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

/// The processes of section `launch`, without the camera: the log stands in its place.
std::vector<std::string> processes(const ConfigNode& config) {
  auto names = read_settings<LaunchSettings>(config.section("launch")).processes;
  names.erase(std::remove(names.begin(), names.end(), "camera"), names.end());
  for (const std::string& name : process_names())  // settings of a preset for processes that do not run
    if (std::find(names.begin(), names.end(), name) == names.end()) config.ignore(name);
  return names;
}

/// Of the channels of the log: which process refused more than half, and why.
void add_refusals(const BatchResult& result, std::vector<std::string>& problems) {
  for (const auto& process : result.processes)
    for (const auto& [channel, refused] : process.refused) {
      const auto delivered = result.delivered_on.find(channel);
      if (delivered == result.delivered_on.end() || 2 * refused.messages <= delivered->second) continue;
      problems.push_back(fmt::format("{} refused {} of {} {} messages, the last because: {}", process.process,
                                     refused.messages, delivered->second, channel, refused.last_reason));
    }
}

/// Calibrations are sent once a second and seldom change. Compared behind fingerprint, utime, seq and sender.
bool is_new_calibration(const std::vector<std::uint8_t>& message, std::vector<std::uint8_t>& known) {
  constexpr std::size_t head = 32;  // bytes
  if (message.size() < head) return false;
  const auto begin = message.begin() + head;
  if (std::equal(begin, message.end(), known.begin(), known.end())) return false;
  known.assign(begin, message.end());
  return true;
}

bool maps(const std::string& process) {
  return process == "fastslam" || process == "icp";
}

}  // namespace

std::vector<std::string> problems_of(const BatchResult& result) {
  if (result.frames == 0)
    return {"the log has no CAMERA and no FEATURES message within the times asked for (lcmslam log info)"};
  std::vector<std::string> problems;
  add_refusals(result, problems);
  for (const auto& process : result.processes)
    if (maps(process.process) && process.published == 0)
      problems.push_back(process.process + " mapped nothing" +
                         (process.report.detail.empty() ? "" : ": it " + process.report.detail));
  for (const auto& process : result.processes)
    if (process.report.state == status_t::FAILED) problems.push_back(process.report.detail);
  return problems;
}

BatchResult run_batch(const BatchOptions& options) {
  BatchResult result;
  std::filesystem::create_directories(options.folder);
  result.output = options.folder / "batch.lcmlog";
  MessageReader log(options.log.string());
  LogWriter output(result.output.string());
  ConfigNode config = options.config;
  config.set("map-server.folder", yaml_quoted(std::filesystem::absolute(options.folder).string()));
  config.set("map-server.snapshot_period", "0");  // an aborted run leaves nothing
  cv::setNumThreads(options.threads);

  Utime now = 0;
  BatchGraph graph(config, processes(config), options.threads, [&](const BatchMessage& message) {
    output.write(now, message.channel, message.bytes);
    if (options.heard) options.heard(message);
  });
  config.finish();

  // The result says by itself where the camera sat (evaluate --truth-frame camera).
  std::vector<std::uint8_t> known_calibration;
  const auto deliver = [&](BatchMessage message) {
    if (message.channel == "CAMERA_CALIBRATION" && is_new_calibration(message.bytes, known_calibration))
      output.write(now, message.channel, message.bytes);
    if (options.heard) options.heard(message);
    graph.deliver(std::move(message));
  };

  SessionTracker sessions;
  bool begins = false;  // no event of this session was delivered yet
  std::optional<Utime> start;
  std::optional<BatchMessage> calibration;  // the last one before `from`
  while (const auto event = log.next()) {
    if (!start) start = event->timestamp;
    begins |= sessions.begins(*event);
    const double seconds = 1e-6 * static_cast<double>(time_between(*start, event->timestamp));
    if (options.to > 0 && seconds > options.to) continue;  // logs are in disorder, or hold several sessions
    BatchMessage message{std::string(event->channel), {}, event->timestamp};
    if (!graph.is_input(message.channel)) continue;
    message.bytes.assign(event->data, event->data + event->size);
    if (seconds < options.from) {
      if (message.channel == "CAMERA_CALIBRATION") calibration = std::move(message);
      continue;
    }
    now = begins ? event->timestamp : std::max(now, event->timestamp);
    begins = false;
    if (calibration) deliver(*std::exchange(calibration, std::nullopt));
    ++result.delivered;
    ++result.delivered_on[message.channel];
    result.frames += message.channel == "CAMERA" || message.channel == "FEATURES" ? 1 : 0;
    result.log_seconds = seconds - options.from;
    deliver(std::move(message));
    if (options.progress) options.progress(result.log_seconds);
  }
  graph.finish();
  result.published = output.events();
  output.close();
  result.events = log.read();
  result.incomplete = log.incomplete();
  result.damages = log.damages().size();
  result.processes = graph.summary();
  return result;
}

}  // namespace lcmslam
