#include <lcmslam/runtime/launch_settings.hpp>

#include <algorithm>
#include <functional>
#include <set>

namespace lcmslam {
namespace {

std::string joined_names(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::vector<const char*> all_sections() {
  std::vector<const char*> names;
  for (const std::string& name : section_names()) names.push_back(name.c_str());
  return names;
}

bool has(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

LaunchSettings::LaunchSettings() {
  for (const std::string& name : section_names()) of[name];
}

void LaunchedProcess::describe(SettingsVisitor& s) {
  s.text("host", host, "that it runs on: what launch --host or the machine's name says; empty: launch.host");
  s.texts("after", after, "processes that must be ready before it starts: their STATUS says that they run",
          all_sections());
  s.numbers("cpus", cpus, "", {0, 1023}, "numbers of the cores that it may use; empty: all");
  s.number("nice", nice, "", {-20, 19}, "priority: 19 stands back for all others; below 0 only as root");
  s.number("memory", memory, "MB", {0, 1e7},
           "private memory that it may have: beyond that it ends and is started again; 0: no limit");
  s.texts("environment", environment, "variables that it gets, such as OMP_NUM_THREADS=1");
}

void LaunchSettings::describe(SettingsVisitor& s) {
  s.texts("processes", processes, "processes that run", all_sections());
  s.flag("restart", restart,
         "a process that dies comes back: at once, if soon again after pauses of 0.2 s to 30 s");
  s.number("restart_limit", restart_limit, "", {0, 1'000'000},
           "so often in a row, each time within 30 s of its start; then it stays away. 0: always");
  s.text(
      "robot", robot,
      "name in front of all channels, NAME/CAMERA: several robots share a bus; empty: none (LCMSLAM_ROBOT)");
  s.text("host", host, "of the processes that name none; empty: wherever launch is started");
  s.number("ttl", ttl, "", {0, 255},
           "of the bus's packets: 1 for hosts on one network; 0: what the LCM URL says");
  s.text(
      "interface", interface,
      "network card that the bus's packets must leave through, e.g. eth0; empty: whichever the route says");
  s.number("clock_offset", clock_offset, "s", {0, 60},
           "between this host's clock and another's that is warned of");
  s.number("log_size", log_size, "MB", {0, 1e6}, "of a process's log, then the next begins; 0: no limit");
  s.number("log_files", log_files, "", {1, 1000},
           "logs of a process that are kept, the one under way included");
  for (auto& [name, process] : of) s.section(name.c_str(), process, "how it is started");
  check(s);
}

void LaunchSettings::check(SettingsVisitor& s) const {
  s.require(!processes.empty(), "processes", "must name at least one process, as in [camera, map-server]");
  const std::set<std::string> different(processes.begin(), processes.end());
  s.require(different.size() == processes.size(), "processes",
            ("must name each process once, got [" + joined_names(processes) + "]").c_str());
  const bool split = !hosts().empty();
  for (const std::string& name : processes) {
    const std::string nowhere =
        "must say where " + name + " runs, as others name a host (or launch.host does)";
    s.require(!split || !host_of(name).empty(), "processes", nowhere.c_str());
    for (const std::string& other : of.at(name).after)
      s.require(has(processes, other), (name + ".after").c_str(),
                ("must name processes that run, got '" + other + "'").c_str());
    for (const std::string& variable : of.at(name).environment)
      s.require(variable.find('=') != std::string::npos && variable[0] != '=',
                (name + ".environment").c_str(), ("must be NAME=VALUE, got '" + variable + "'").c_str());
  }
  const std::string circle = circle_of(*this);
  s.require(circle.empty(), "processes", ("must not wait for each other in a circle: " + circle).c_str());
}

std::string LaunchSettings::host_of(const std::string& process) const {
  const auto found = of.find(process);
  return found != of.end() && !found->second.host.empty() ? found->second.host : host;
}

std::vector<std::string> LaunchSettings::hosts() const {
  std::vector<std::string> names;
  for (const std::string& process : processes)
    if (const std::string name = host_of(process); !name.empty() && !has(names, name)) names.push_back(name);
  return names;
}

std::string circle_of(const LaunchSettings& settings) {
  std::set<std::string> done;
  std::vector<std::string> path;
  const std::function<bool(const std::string&)> closes = [&](const std::string& name) {
    if (done.count(name) > 0) return false;
    const bool again = has(path, name);
    path.push_back(name);
    if (again) return true;
    for (const std::string& other : settings.of.at(name).after)
      if (closes(other)) return true;
    path.pop_back();
    done.insert(name);
    return false;
  };
  for (const std::string& name : settings.processes)
    if (closes(name)) return joined_names({std::find(path.begin(), path.end(), path.back()), path.end()});
  return {};
}

}  // namespace lcmslam
