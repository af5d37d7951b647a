#include "tools/batch/batch_run.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <opencv2/core/utility.hpp>

#include <lcmslam/configuration/yaml_text.hpp>
#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/status_t.hpp>
#include "tools/log/log_session.hpp"
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

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

/// Whether a mapper gave the pose of a frame.
bool mapped(const BatchResult& result, const char* pose_channel) {
  const auto poses = result.published_on.find(pose_channel);
  return poses != result.published_on.end() && poses->second > 0;
}

double value_of(const NodeReport& report, const std::string& name) {
  for (const auto& [key, value] : report.values)
    if (key == name) return value;
  return 0;
}

void add_unmapped(const BatchResult& result, std::vector<std::string>& problems) {
  const std::pair<const char*, const char*> mappers[] = {{"fastslam", "FASTSLAM_POSE"}, {"icp", "ICP_POSE"}};
  for (const auto& process : result.processes)
    for (const auto& [mapper, pose_channel] : mappers) {
      if (process.process != mapper) continue;
      const auto blind = static_cast<std::int64_t>(value_of(process.report, "without_odometry"));
      if (!mapped(result, pose_channel))
        problems.push_back(process.process + " mapped nothing" +
                           (process.report.detail.empty() ? "" : ": it " + process.report.detail));
      else if (2 * blind > result.frames)
        problems.push_back(
            fmt::format("{} had no odometry for {} of {} frames (lcmslam log info says what the log has)",
                        process.process, blind, result.frames));
    }
}

/// The calibration as the log's own would come.
BatchMessage calibration_message(const RgbdCalibration& calibration, Utime utime) {
  camera_calibration_t message = to_message(calibration);
  message.utime = utime;
  message.seq = 0;
  message.sender = 0;
  return {"CAMERA_CALIBRATION", encode_message(message), utime};
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

}  // namespace

std::vector<std::string> problems_of(const BatchResult& result) {
  if (result.frames == 0)
    return {"the log has no CAMERA and no FEATURES message within the times asked for (lcmslam log info)"};
  std::vector<std::string> problems;
  add_refusals(result, problems);
  add_unmapped(result, problems);
  for (const auto& process : result.processes)
    if (process.report.state == status_t::FAILED) problems.push_back(process.report.detail);
  return problems;
}

BatchPlan plan_batch(const BatchOptions& options) {
  return plan_batch(options.config, options.log.string(), read_offer(options.log, {options.from, options.to}),
                    options.calibration.has_value());
}

BatchResult run_batch(const BatchOptions& options, const BatchPlan& plan) {
  BatchResult result;
  std::filesystem::create_directories(options.folder);
  result.output = options.folder / "batch.lcmlog";
  MessageReader log(options.log.string());
  LogWriter output(result.output.string());
  ConfigNode config = plan.config;
  config.set("map-server.folder", yaml_quoted(std::filesystem::absolute(options.folder).string()));
  config.set("map-server.snapshot_period", "0");  // an aborted run leaves nothing
  config.set("map-server.layers.background", "false");
  config.set("map-server.places", "false");
  config.set("map-server.store", "''");  // its bytes depend on the clock, a batch's do not
  // Of more threads than processors TBB prints a warning.
  cv::setNumThreads(std::min(options.threads, cv::getNumberOfCPUs()));

  Utime now = 0;
  BatchGraph graph(config, plan.processes, options.threads, [&](const BatchMessage& message) {
    ++result.published_on[message.channel];
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

  const LogSpan span{options.from, options.to};
  SessionTracker sessions;
  bool begins = false;  // no event of this session was delivered yet
  std::optional<Utime> start;
  std::optional<BatchMessage> calibration;  // the last one before `from`
  while (const auto event = log.next()) {
    if (!start) start = event->timestamp;
    begins |= sessions.begins(*event);
    const double seconds = 1e-6 * static_cast<double>(time_between(*start, event->timestamp));
    BatchMessage message{
        std::string(event->channel == plan.camera ? "CAMERA" : event->channel), {}, event->timestamp};
    if (!graph.is_input(message.channel)) continue;
    const bool calibrates = message.channel == "CAMERA_CALIBRATION";
    if (calibrates && options.calibration) continue;
    if (!span.holds(seconds) && !(calibrates && span.is_before(seconds))) continue;
    message.bytes.assign(event->data, event->data + event->size);
    if (span.is_before(seconds)) {
      calibration = std::move(message);
      continue;
    }
    now = begins ? event->timestamp : std::max(now, event->timestamp);
    begins = false;
    if (options.calibration && result.delivered == 0)
      calibration = calibration_message(*options.calibration, event->timestamp);
    if (calibration) deliver(*std::exchange(calibration, std::nullopt));
    ++result.delivered;
    ++result.delivered_on[message.channel];
    result.frames += message.channel == "CAMERA" || message.channel == "FEATURES" ? 1 : 0;
    result.log_seconds = seconds - options.from;
    deliver(std::move(message));
    if (options.progress) options.progress(result.frames);
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
