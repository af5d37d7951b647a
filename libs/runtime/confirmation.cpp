#include <lcmslam/runtime/confirmation.hpp>

#include <algorithm>

namespace lcmslam {

bool needs_confirmation(const command_t& command) {
  return command.name == "stop" || command.name == "reset";
}

bool is_confirmed(const command_t& command, const std::string& process, std::int64_t sender) {
  const std::string word = std::to_string(sender);
  for (std::size_t i = 0; i < std::min(command.keys.size(), command.values.size()); ++i)
    if (command.keys[i] == process && command.values[i] == word) return true;
  return false;
}

}  // namespace lcmslam
