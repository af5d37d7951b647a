#include <lcmslam/live_page/health.hpp>

#include <fmt/format.h>

namespace lcmslam {
namespace {

constexpr double silent_after = 3.5;   // s; STATUS comes once a second
constexpr double forgiven_after = 15;  // s since a count rose
constexpr double told_for = 60;        // s that an end is told
constexpr double late = 0.3;           // s of latency that an operator notices
constexpr std::int64_t few = 3;        // losses at a start are nobody's fault

Complaint complaint_of(const MapperSaid& mapper) {
  if (mapper.status == "LOST")
    return {Level::bad, mapper.name + " is lost: nothing that it sees agrees with its map",
            "uncover the camera, or drive slowly back to where the map is known"};
  if (mapper.status == "DEGRADED")
    return {Level::warn, mapper.name + " is unsure" + (mapper.detail.empty() ? "" : ": " + mapper.detail),
            "drive slowly; show it a place that has shape and texture"};
  return {};
}

/// Whose own process, or that of what it listens to, says why.
Complaint silence_of(const MapperSaid& mapper, const std::vector<ProcessSaid>& processes) {
  if (mapper.status != "SILENT") return {};
  std::string why;
  for (const ProcessSaid& p : processes) {
    if (p.state == "finished") return {};  // a log is at its end
    if (p.name == mapper.name && !p.detail.empty()) why = ": " + p.detail;
  }
  return {Level::bad, mapper.name + " tells no position any more" + why,
          "see whether the camera is plugged in and its process runs"};
}

const Complaint& worse(const Complaint& a, const Complaint& b) {
  return b.level > a.level ? b : a;
}

}  // namespace

const char* to_string(Level level) {
  return level == Level::good ? "good" : level == Level::warn ? "warn" : "bad";
}

Complaint Health::complaint_of(const ProcessSaid& p, double now) {
  Counts& known = counts_[p.name];
  const auto rises = [&](std::int64_t Counts::*before, std::int64_t count, Complaint complaint) {
    // A smaller count is that of a process that began anew.
    const bool rose = count > known.*before + (known.*before == 0 ? few : 0);
    if (rose) known.risen = now, known.complaint = std::move(complaint);
    if (rose || count < known.*before) known.*before = count;
  };
  rises(&Counts::dropped, p.dropped,
        {Level::warn, p.name + " leaves messages out: it cannot keep up",
         "lower the camera's rate or size; see who else uses the processor"});
  rises(&Counts::lost, p.lost,
        {Level::warn, p.name + " misses messages of its inputs",
         "`lcmslam doctor` shows whether the bus loses them"});
  rises(&Counts::kernel_drops, p.kernel_drops,
        {Level::warn, "the system drops messages for " + p.name,
         "`lcmslam doctor` prints the line that enlarges the receive buffer"});
  rises(&Counts::unreadable, p.unreadable,
        {Level::warn, p.name + " hears messages that it cannot read",
         "`lcmslam spy` shows their channel; another program publishes there"});

  if (p.state == "failed")
    return {Level::bad, p.name + " failed" + (p.detail.empty() ? "" : ": " + p.detail),
            "its last lines in the terminal tell why"};
  if (p.state == "stopping" && p.age > silent_after) {
    if (p.age > told_for) return {};  // as somebody wanted
    return {Level::warn, p.name + " has been ended", "start it again where that was not wanted"};
  }
  if (p.state != "finished" && p.age > silent_after)
    return {Level::bad, fmt::format("{} has been silent for {:.0f} s", p.name, p.age),
            "`lcmslam launch` starts it again; its last lines in the terminal tell why it ended"};
  if (now - known.risen < forgiven_after) return known.complaint;
  if (p.latency_p95 > late)
    return {Level::warn, fmt::format("{} answers late: {:.0f} ms", p.name, 1e3 * p.latency_p95),
            "lower the camera's rate or size; see who else uses the processor"};
  return {};
}

PageItem Health::item(const std::vector<ProcessSaid>& processes, const std::vector<MapperSaid>& mappers,
                      double now) {
  Complaint worst;
  for (const MapperSaid& mapper : mappers) worst = worse(worst, lcmslam::complaint_of(mapper));
  nlohmann::json all = nlohmann::json::array();
  for (const ProcessSaid& p : processes) {
    const Complaint complaint = complaint_of(p, now);
    worst = worse(worst, complaint);
    all.push_back({{"name", p.name},
                   {"level", to_string(complaint.level)},
                   {"state", p.state},
                   {"words", complaint.words.empty() ? p.detail : complaint.words},
                   {"mend", complaint.mend},
                   {"cpu", rounded_for_page(p.cpu)},
                   {"memory", p.memory},
                   {"latency", {rounded_for_page(p.latency_p50), rounded_for_page(p.latency_p95)}},
                   {"rate", rounded_for_page(p.rate)}});
  }
  for (const MapperSaid& mapper : mappers) worst = worse(worst, silence_of(mapper, processes));
  if (worst.level == Level::good)
    worst.words = processes.empty() ? "no process has spoken yet" : "all is well";
  PageItem item{"health", ""};
  item.header = {{"level", to_string(worst.level)}, {"words", worst.words}, {"mend", worst.mend}};
  item.header["processes"] = std::move(all);
  return item;
}

}  // namespace lcmslam
