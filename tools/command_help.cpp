#include "tools/command_help.hpp"

#include <utility>

namespace lcmslam {

const char* command_help(const std::string& command) {
  static const std::pair<const char*, const char*> lines[] = {
      {"batch", "run the whole graph in one process straight from a log, or many logs side by side"},
      {"bridge", "carry chosen channels to an MQTT broker and from it"},
      {"calibrate", "cameras, their place on the robot and its wheels, from a board or a drive"},
      {"collect", "the results of many logs in one table and page, beside another farm's"},
      {"completion", "print the completion of this command for bash or zsh; write its manual pages"},
      {"config", "say what can be configured; check a file"},
      {"demo", "run the whole graph live and show both maps"},
      {"doctor", "look for what makes LCM lose messages on this machine"},
      {"evaluate", "errors of trajectories against the truth"},
      {"echo", "print the messages of a channel, decoded"},
      {"export", "a kept map as one page that opens offline in any browser"},
      {"import", "turn a data set folder, a ROS bag or an MCAP file into an .lcmlog"},
      {"launch", "start the process graph that a configuration names"},
      {"lcm-spy", "the stock graphical spy with our types"},
      {"log", "recordings: info, check, repair, cut, calibrate, play, view, export"},
      {"map", "map files (.lcmslam): info, export, view, merge, compact, verify, diff"},
      {"query", "ask the running map server: distances, collisions, planes, a mesh ..."},
      {"render", "a picture of a map, or one that turns"},
      {"send", "an order to the running graph: save, smooth, reset, stop, export"},
      {"simulate", "render a simulated run into an .lcmlog"},
      {"spy", "live table of the bus"},
      {"study", "run the demo for several seeds, or one study of its own"}};
  for (const auto& [name, help] : lines)
    if (command == name) return help;
  return "";
}

}  // namespace lcmslam
