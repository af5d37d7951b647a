#include "tools/evaluate/pose_omissions.hpp"

namespace lcmslam {
namespace {

std::string plural(std::int64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

std::vector<std::string> omissions(const PoseLog& log, const std::string& file) {
  if (log.damages() == 0) return {};
  return {file + " is damaged in " + plural(static_cast<std::int64_t>(log.damages()), "place") +
          ": events there are left out"};
}

std::vector<std::string> omissions(const PoseChannel& channel, const std::string& name) {
  std::vector<std::string> all;
  if (channel.restarts > 0)
    all.push_back(name + " began again " + plural(channel.restarts, "time") +
                  ": only the newest map counts, " + plural(channel.left_out, "earlier pose") + " left out");
  if (channel.unplaced > 0)
    all.push_back(name + ": " + plural(channel.unplaced, "pose") + " without a keyframe before " +
                  (channel.unplaced == 1 ? "it" : "them") + " left out");
  if (channel.undecodable > 0)
    all.push_back(name + ": " + plural(channel.undecodable, "message") + " could not be decoded");
  return all;
}

}  // namespace lcmslam
