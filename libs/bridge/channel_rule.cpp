#include <lcmslam/bridge/channel_rule.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <stdexcept>

namespace lcmslam::bridge {
namespace {

[[noreturn]] void refuse(const std::string& text) {
  throw std::invalid_argument("'" + text +
                              "' must be a channel of letters, digits and underscores, perhaps with the most "
                              "messages a second, such as FASTSLAM_POSE@5");
}

}  // namespace

ChannelRule parse_rule(const std::string& text) {
  const std::size_t at = text.find('@');
  ChannelRule rule;
  rule.channel = text.substr(0, at);
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  // No '/', '+' and '#': they mean something in topics.
  if (rule.channel.empty() || rule.channel.size() > 50 ||
      !std::all_of(rule.channel.begin(), rule.channel.end(), fits))
    refuse(text);
  if (at == std::string::npos) return rule;
  const std::string number = text.substr(at + 1);
  std::size_t read = 0;
  try {
    rule.rate = std::stod(number, &read);
  } catch (const std::exception&) {
    refuse(text);
  }
  if (read != number.size() || !(rule.rate > 0) || rule.rate > 1000) refuse(text);
  return rule;
}

bool is_large(const std::string& channel) {
  constexpr std::array large = {"CAMERA", "FASTSLAM_LANDMARKS", "ICP_GRAPH", "ICP_KEYFRAME", "MAP_REPLY"};
  return std::find(large.begin(), large.end(), channel) != large.end();
}

std::vector<ChannelRule> parse_rules(const std::vector<std::string>& texts) {
  std::vector<ChannelRule> rules;
  std::set<std::string> channels;
  for (const std::string& text : texts) {
    rules.push_back(parse_rule(text));
    if (!channels.insert(rules.back().channel).second)
      throw std::invalid_argument("the bridge must be told of " + rules.back().channel + " once");
  }
  return rules;
}

}  // namespace lcmslam::bridge
