#include "tools/study/faults/fault_responses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace lcmslam {
namespace {

constexpr double near = 0.1;    // m
constexpr double settled = 2;   // s after a mapper is right again
constexpr double patience = 3;  // s after the fault in which it may be told
const std::set<std::string> told_values = {"stamps_refused",
                                           "of_other_senders",
                                           "store_failures",
                                           "malformed_frames",
                                           "commands_refused",
                                           "degraded",
                                           "lost"};

double value_of(const status_t& status, const std::string& name) {
  for (const auto& value : status.values)
    if (value.name == name) return value.value;
  return 0;
}

std::int64_t losses(const status_t& status) {
  std::int64_t sum = status.kernel_drops;
  for (const auto& input : status.inputs)
    sum += input.decode_errors + input.lost + input.duplicates + input.reordered + input.queue_drops;
  return sum;
}

double rms(const std::vector<MapperWatch::Held>& poses, double from, double to) {
  double sum = 0;
  int n = 0;
  for (const auto& pose : poses) {
    if (!pose.tracking || pose.at < from || pose.at >= to) continue;
    sum += pose.error * pose.error;
    ++n;
  }
  return n > 0 ? std::sqrt(sum / n) : std::numeric_limits<double>::quiet_NaN();
}

/// `held`: the mapper's poses of a run.
MapperResponse response(const RunRecord& run, const std::vector<RunRecord>& undisturbed,
                        std::vector<MapperWatch::Held> RunRecord::*held, double end, double next) {
  MapperResponse result;
  for (const auto& pose : run.*held) {
    if (pose.at < end || pose.at >= next || !pose.tracking || pose.error > near) continue;
    result.found = pose.at - end;
    break;
  }
  const double from = end + result.found.value_or(0) + settled;
  result.error = rms(run.*held, from, next);
  double squares = 0;
  for (const RunRecord& usual : undisturbed) {
    const double error = rms(usual.*held, from, next);
    squares += error * error;
    result.worst = std::max(result.worst, error);
  }
  result.usual = std::sqrt(squares / static_cast<double>(undisturbed.size()));
  return result;
}

}  // namespace

std::string trouble_told(const status_t& before, const status_t& now) {
  if (now.pid != before.pid) return now.process + " restarted";
  if (now.state == status_t::FAILED && before.state != now.state) return now.process + " failed";
  for (const std::string& name : told_values)
    if (value_of(now, name) > value_of(before, name)) return now.process + ": " + name;
  if (losses(now) > losses(before)) return now.process + ": inputs' losses";
  if (!now.detail.empty() && now.detail != before.detail) return now.process + ": " + now.detail;
  return {};
}

std::vector<FaultResponse> fault_responses(const std::vector<Fault>& faults, const RunRecord& run,
                                           const std::vector<RunRecord>& undisturbed) {
  std::vector<FaultResponse> responses;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    FaultResponse response_of{faults[i], {}, {}, {}, {}};
    const double begin = faults[i].at, end = begin + faults[i].seconds;
    const double next = i + 1 < faults.size() ? faults[i + 1].at : std::numeric_limits<double>::infinity();
    const auto tell = [&](double at, const std::string& who) {
      if (at < begin || at >= std::min(end + patience, next)) return;
      if (response_of.told && *response_of.told <= at - begin) return;
      response_of.told = at - begin;
      response_of.by = who;
    };
    // Of a busy machine losses are told all the time: what was told just before tells nothing of the fault.
    const auto was_told = [&](const Alarm& alarm) {
      return std::any_of(run.alarms.begin(), run.alarms.end(), [&](const Alarm& other) {
        return other.text == alarm.text && other.at < begin && other.at >= begin - patience;
      });
    };
    for (const Alarm& alarm : run.alarms)
      if (!was_told(alarm)) tell(alarm.at, alarm.text);
    for (const auto& [poses, name] : {std::pair(&run.fastslam, "FASTSLAM_POSE"), {&run.icp, "ICP_POSE"}})
      for (const auto& pose : *poses)
        if (!pose.tracking) tell(pose.at, name);
    response_of.fastslam = response(run, undisturbed, &RunRecord::fastslam, end, next);
    response_of.icp = response(run, undisturbed, &RunRecord::icp, end, next);
    responses.push_back(response_of);
  }
  return responses;
}

}  // namespace lcmslam
