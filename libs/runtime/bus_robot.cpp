#include <lcmslam/runtime/bus_robot.hpp>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <stdexcept>

namespace lcmslam {

std::string robot_prefix() {
  const char* name = std::getenv("LCMSLAM_ROBOT");
  if (name == nullptr || *name == '\0') return {};
  check_robot_name(name);
  return std::string(name) + "/";
}

void check_robot_name(const std::string& name) {
  constexpr std::size_t longest = 32;
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; };
  if (name.empty() || name.size() > longest || !std::all_of(name.begin(), name.end(), fits))
    throw std::invalid_argument("the robot's name '" + name +
                                "' must be 1 to 32 letters, digits, dashes and underscores");
}

void set_robot(const std::string& name) {
  if (name.empty()) return;
  check_robot_name(name);
  setenv("LCMSLAM_ROBOT", name.c_str(), 1);
}

std::string without_robot(const std::string& channel) {
  const std::size_t slash = channel.find('/');
  return slash == std::string::npos ? channel : channel.substr(slash + 1);
}

bool RobotReader::read(BusMessage& message, std::chrono::milliseconds wait) {
  if (!source_->read(message, wait)) return false;
  message.channel.erase(0, prefix_.size());
  return true;
}

}  // namespace lcmslam
