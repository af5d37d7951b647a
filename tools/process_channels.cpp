#include "tools/process_channels.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include <lcmslam/runtime/clock_comparison.hpp>

namespace lcmslam {
namespace {

struct Work {
  std::vector<std::string> from;     // any of these; none: whatever there is
  std::vector<std::string> outputs;  // channels, or their beginning with an underscore at its end
};

const std::map<std::string, Work>& works() {
  static const std::map<std::string, Work> all = {
      {"surf", {{"CAMERA"}, {"FEATURES"}}},
      {"odometry", {{"ENCODERS", "TWIST", "POSE_BODY", "FEATURES"}, {"ODOMETRY"}}},
      {"fastslam", {{"FEATURES"}, {"FASTSLAM_"}}},
      {"icp", {{"CAMERA"}, {"ICP_"}}},
      {"map-server", {{}, {"MAP_REPLY"}}},
  };
  return all;
}

bool is_of(const std::string& channel, const std::string& output) {
  return output.back() == '_' ? channel.rfind(output, 0) == 0 : channel == output;
}

}  // namespace

bool is_told(const std::string& channel) {
  return channel == "COMMAND" || channel == "MAP_REQUEST" || channel == "STATUS" || channel == clock_channel;
}

bool makes(const std::string& process, const std::string& channel) {
  const auto work = works().find(process);
  return work != works().end() &&
         std::any_of(work->second.outputs.begin(), work->second.outputs.end(),
                     [&](const std::string& output) { return is_of(channel, output); });
}

std::set<std::string> computed_channels(const std::set<std::string>& in_log,
                                        const std::set<std::string>& processes) {
  std::set<std::string> working;
  const auto made = [&](const std::string& channel) {
    return std::any_of(working.begin(), working.end(),
                       [&](const std::string& process) { return makes(process, channel); });
  };
  for (std::size_t before = SIZE_MAX; before != working.size();) {  // who works gives work to others
    before = working.size();
    for (const auto& [process, work] : works())
      if (processes.count(process) > 0 &&
          (work.from.empty() ||
           std::any_of(work.from.begin(), work.from.end(), [&](const std::string& channel) {
             return in_log.count(channel) > 0 || made(channel);
           })))
        working.insert(process);
  }
  std::set<std::string> computed;
  std::copy_if(in_log.begin(), in_log.end(), std::inserter(computed, computed.end()), made);
  return computed;
}

}  // namespace lcmslam
