#include <lcmslam/bridge/topics.hpp>

#include <algorithm>
#include <stdexcept>

namespace lcmslam::bridge {
namespace {

void check(const std::string& text, const char* what, const char* forbidden) {
  const auto fits = [&](unsigned char c) {
    return c > ' ' && c < 127 && std::string(forbidden).find(static_cast<char>(c)) == std::string::npos;
  };
  if (text.empty() || text.size() > 100 || !std::all_of(text.begin(), text.end(), fits))
    throw std::invalid_argument(std::string(what) + " '" + text +
                                "' must be 1 to 100 printable characters that mean nothing in topics");
}

}  // namespace

Topics::Topics(const std::string& prefix, const std::string& robot, Side side)
    : base_(prefix + "/" + robot + "/"), side_(side == Side::robot ? "robot" : "operator") {
  check(prefix, "the topics' prefix", "+#$");
  check(robot, "the robot's name", "+#$/");
  out_ = base_ + (side == Side::robot ? "from/" : "to/");
  in_ = base_ + (side == Side::robot ? "to/" : "from/");
}

std::string Topics::channel_of(std::string_view topic) const {
  if (topic.size() <= in_.size() || topic.substr(0, in_.size()) != in_) return {};
  topic.remove_prefix(in_.size());
  return std::string(topic.substr(0, topic.find('/')));
}

}  // namespace lcmslam::bridge
