#include <lcmslam/runtime/bus_reader.hpp>

#include <stdexcept>

namespace lcmslam {
namespace {

/// As a regular expression that matches nothing else.
std::string quoted(const std::string& name) {
  std::string quoted;
  for (const char c : name) {
    if (std::string(R"(\^$.|?*+()[]{})").find(c) != std::string::npos) quoted += '\\';
    quoted += c;
  }
  return quoted;
}

}  // namespace

ChannelSet ChannelSet::matching(const std::string& pattern) {
  ChannelSet set({});
  set.pattern_ = pattern;
  try {
    set.expression_.emplace(pattern, std::regex::ECMAScript | std::regex::optimize);
  } catch (const std::regex_error&) {
    throw std::invalid_argument(pattern + " is no regular expression of channels");
  }
  return set;
}

ChannelSet ChannelSet::below(const std::string& prefix) const {
  if (expression_) return matching(quoted(prefix) + "(?:" + pattern_ + ")");
  std::set<std::string> names;
  for (const std::string& name : names_) names.insert(prefix + name);
  return ChannelSet(names);
}

bool ChannelSet::holds(const std::string& channel) const {
  return expression_ ? std::regex_match(channel, *expression_) : names_.count(channel) > 0;
}

std::vector<std::string> ChannelSet::patterns() const {
  if (expression_) return {"(?:" + pattern_ + ")"};
  std::vector<std::string> patterns;
  for (const std::string& name : names_) patterns.push_back(quoted(name));
  return patterns;
}

}  // namespace lcmslam
