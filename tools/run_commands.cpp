#include "tools/run_commands.hpp"

#include <poll.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <exception>
#include <iostream>

#include <lcmslam/runtime/version.hpp>
#include "tools/launch/graph.hpp"

namespace lcmslam {
namespace {

/// What was printed must have arrived: a full disk behind `> file` is an error, a reader that went away
/// (`| head`) is none.
int check_output(int exit_code) {
  if (std::cout.flush()) return exit_code;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  const bool reader_left = poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
  if (reader_left) return exit_code;
  std::cerr << "lcmslam: standard output cannot be written: is its disk full?\n";
  return exit_code == 0 ? 1 : exit_code;
}

bool is(const char* name, const char* other) {
  return std::strcmp(name, other) == 0;
}

}  // namespace

int run_commands(const std::vector<Command>& commands, int argc, char** argv) {
  const char* name = argc > 1 ? argv[1] : "";
  for (const Command& command : commands) {
    if (!is(command.name, name)) continue;
    try {
      return check_output(command.run(argc - 1, argv + 1));
    } catch (const std::exception& error) {
      std::cerr << "lcmslam " << name << ": " << error.what() << "\n";
      return 1;
    }
  }
  if (is(name, "--version")) {
    std::cout << "lcmslam " << lcmslam_version << "\n";
    return 0;
  }
  if (is(name, "--help") || is(name, "help")) {
    std::cout << "usage: lcmslam COMMAND [options]; lcmslam COMMAND --help for its options. Commands:";
    for (const Command& command : commands) std::cout << " " << command.name;
    std::cout << "\n";
    return 0;
  }
  std::cerr << "lcmslam: unknown command '" << name << "'; lcmslam help lists them\n";
  return 2;
}

void hand_over(const char* program, char** argv) {
  const std::string path = program_folder() / program;
  execv(path.c_str(), argv);
  throw std::runtime_error(path + ": " + std::strerror(errno) +
                           "; a whole build makes it: cmake --build build/release --target programs");
}

}  // namespace lcmslam
