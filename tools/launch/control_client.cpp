#include "tools/launch/control_client.hpp"

#include <unistd.h>
#include <algorithm>
#include <iostream>
#include <thread>

#include "tools/launch/control.hpp"

namespace lcmslam {

int control_launch(const std::string& request, const std::string& robot) {
  auto launches = running_launches();
  if (!robot.empty())
    launches.erase(std::remove_if(launches.begin(), launches.end(),
                                  [&](const auto& socket) {  // ROBOT-PID.*, and names may have dashes
                                    const std::string name = socket.filename().string();
                                    return name.substr(0, name.rfind('-')) != robot;
                                  }),
                   launches.end());
  if (launches.empty()) {
    std::cerr << "lcmslam launch: none of yours runs here" << (robot.empty() ? "" : " for " + robot) << "\n";
    return 3;
  }
  if (launches.size() > 1) {
    std::cerr << "lcmslam launch: several run; say which by --robot NAME:\n";
    for (const auto& socket : launches) std::cerr << "  " << socket.filename().stem().string() << "\n";
    return 2;
  }
  const auto answer = ask_launch(launches.front(), request);
  if (!answer) {
    std::cerr << "lcmslam launch: " << launches.front().string() << " does not answer\n";
    return 1;
  }
  const bool refused = answer->rfind("refused: ", 0) == 0;
  (refused ? std::cerr : std::cout) << *answer << std::flush;
  if (request != "stop" || refused) return refused ? 1 : 0;
  // Until it has saved all and is gone.
  while (is_listened_to(launches.front())) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  if (!std::filesystem::exists(launches.front())) {
    std::cout << "stopped\n";
    return 0;
  }
  std::filesystem::remove(launches.front());
  std::cerr << "lcmslam launch: was killed before it had stopped; its processes stop on their own\n";
  return 1;
}

}  // namespace lcmslam
