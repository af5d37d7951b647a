#include <poll.h>
#include <unistd.h>
#include <cstring>
#include <exception>
#include <iostream>

#include <lcmslam/runtime/options.hpp>
#include "tools/commands.hpp"

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

}  // namespace

int main(int argc, char** argv) {
  using namespace lcmslam;
  const char* name = argc > 1 ? argv[1] : "";
  for (const Command& command : commands()) {
    if (std::strcmp(command.name, name) != 0) continue;
    try {
      return check_output(command.run(argc - 1, argv + 1));
    } catch (const std::exception& error) {
      std::cerr << "lcmslam " << name << ": " << error.what() << "\n";
      return 1;
    }
  }
  if (std::strcmp(name, "--version") == 0) {
    std::cout << "lcmslam " << lcmslam_version << "\n";
    return 0;
  }
  if (std::strcmp(name, "--help") == 0) {
    std::cout << "usage: lcmslam COMMAND [options]; lcmslam COMMAND --help for its options. Commands:";
    for (const Command& command : commands()) std::cout << " " << command.name;
    std::cout << "\n";
    return 0;
  }
  std::cerr << "lcmslam: unknown command '" << name << "'; ./lcmslam help lists them\n";
  return 2;
}
