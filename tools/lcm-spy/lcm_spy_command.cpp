#include <fmt/format.h>
#include <unistd.h>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/runtime/options.hpp>
#include "tools/commands.hpp"
#include "tools/lcm-spy/spy_launch.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

std::string from_environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

int lcm_spy_command(int argc, char** argv) {
  std::string lcm_url;
  bool print = false;
  CLI::App app{
      "Starts the stock graphical lcm-spy (Java) with our types. A double click on CAMERA shows its images,\n"
      "one on a channel of poses the paths of both mappers, one on FASTSLAM_ASSOCIATIONS what became of "
      "each\n"
      "feature. Further options go to lcm-spy.",
      "lcmslam lcm-spy"};
  app.add_option("--lcm-url", lcm_url,
                 "LCM provider; default LCM_DEFAULT_URL or " + std::string(default_lcm_url));
  app.add_flag("--print", print, "only print the command");
  app.allow_extras();
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (lcm_url.empty()) lcm_url = lcm_url_from_environment();

  const SpyParts parts =
      find_spy_parts(from_environment("PATH"), {"/usr/share/java", "/usr/local/share/java"},
                     share_folder() / "java", from_environment("DISPLAY"));
  const std::string obstacle = print ? missing_part(parts) : spy_obstacle(parts);
  if (!obstacle.empty()) throw std::runtime_error(obstacle);
  std::vector<std::string> arguments = spy_arguments(parts, lcm_url, app.remaining());
  if (print) {
    std::cout << "LCM_DEFAULT_URL='" << lcm_url << "'";
    for (const std::string& argument : arguments) std::cout << " '" << argument << "'";
    std::cout << "\n";
    return 0;
  }
  // Our windows listen by themselves, on the bus of the environment.
  setenv("LCM_DEFAULT_URL", lcm_url.c_str(), 1);
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  execv(pointers[0], pointers.data());
  throw std::runtime_error(fmt::format("{} cannot be started: {}", arguments[0], std::strerror(errno)));
}

}  // namespace lcmslam
