#pragma once
// "FASTSLAM_POSE@5": a channel that the bridge carries, and how often.

#include <optional>
#include <string>
#include <vector>

namespace lcmslam::bridge {

struct ChannelRule {
  std::string channel;
  double rate = 0;  ///< Hz at most; 0: every message
};

/// Throws std::invalid_argument that says what would be right.
ChannelRule parse_rule(const std::string& text);

/// Makes maps or pictures: a packet of it that is lost must hold up no pose.
bool is_large(const std::string& channel);

/// Each channel once. Throws std::invalid_argument.
std::vector<ChannelRule> parse_rules(const std::vector<std::string>& texts);

}  // namespace lcmslam::bridge
