#include "tools/run_commands.hpp"

#include <poll.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <exception>
#include <iostream>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/configuration/nearest_word.hpp>
#include <lcmslam/runtime/terminal_colours.hpp>
#include <lcmslam/runtime/version.hpp>
#include "tools/command_help.hpp"
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

/// How each line of ours that tells of a failure begins.
std::string prefix(const std::string& name) {
  const std::string text = name.empty() ? "lcmslam:" : "lcmslam " + name + ":";
  return emphasised(text, Emphasis::failure, wants_colours(STDERR_FILENO)) + " ";
}

void print_help(std::ostream& stream, const std::vector<Command>& commands) {
  stream << "usage: lcmslam COMMAND [options]; lcmslam help COMMAND for its options\n";
  for (const Command& command : commands)
    stream << "  " << command.name << std::string(12 - std::strlen(command.name), ' ')
           << command_help(command.name) << "\n";
}

void print_subcommands(std::ostream& stream, const std::string& command,
                       const std::vector<Command>& subcommands) {
  stream << "usage: lcmslam " << command << " SUBCOMMAND [options]; lcmslam " << command
         << " SUBCOMMAND --help for its options\n";
  for (const Command& subcommand : subcommands)
    stream << "  " << subcommand.name << std::string(11 - std::strlen(subcommand.name), ' ')
           << subcommand.help << "\n";
}

/// `help log cut` is `log cut --help`.
int run_help(const std::vector<Command>& commands, int argc, char** argv) {
  char option[] = "--help";
  std::vector<char*> line = {argv[0]};
  line.insert(line.end(), argv + 2, argv + argc);
  line.push_back(option);
  line.push_back(nullptr);
  return run_commands(commands, static_cast<int>(line.size()) - 1, line.data());
}

}  // namespace

int run_subcommand(const char* command, const std::vector<Command>& subcommands, int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  for (const Command& subcommand : subcommands)
    if (name == subcommand.name) return subcommand.run(argc - 1, argv + 1);
  if (name == "--help" || name == "-h") {
    print_subcommands(std::cout, command, subcommands);
    return 0;
  }
  std::vector<std::string> names;
  for (const Command& subcommand : subcommands) names.emplace_back(subcommand.name);
  if (!name.empty())
    std::cerr << "lcmslam " << command << ": unknown subcommand '" << name << "'" << did_you_mean(name, names)
              << "\n";
  print_subcommands(std::cerr, command, subcommands);
  return 2;
}

int run_commands(const std::vector<Command>& commands, int argc, char** argv) {
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "", std::make_shared<spdlog::sinks::stdout_color_sink_mt>(log_colours(STDOUT_FILENO))));
  const char* name = argc > 1 ? argv[1] : "";
  for (const Command& command : commands) {
    if (!is(command.name, name)) continue;
    try {
      return check_output(command.run(argc - 1, argv + 1));
    } catch (const ConfigError& error) {
      std::cerr << prefix(name) << error.what() << "\n";
      return 2;
    } catch (const std::exception& error) {
      std::cerr << prefix(name) << error.what() << "\n";
      return 1;
    }
  }
  if (is(name, "--version")) {
    std::cout << "lcmslam " << lcmslam_version << "\n";
    return 0;
  }
  if (is(name, "help") && argc > 2) return run_help(commands, argc, argv);
  if (is(name, "--help") || is(name, "-h") || is(name, "help")) {
    print_help(std::cout, commands);
    return check_output(0);
  }
  if (argc < 2) {
    print_help(std::cerr, commands);
    return 2;
  }
  std::vector<std::string> names;
  for (const Command& command : commands) names.emplace_back(command.name);
  std::cerr << prefix("") << "unknown command '" << name << "'" << did_you_mean(name, names)
            << "; lcmslam help lists them\n";
  return 2;
}

void hand_over(const char* program, char** argv) {
  const std::string path = program_folder() / program;
  execv(path.c_str(), argv);
  throw std::runtime_error(path + ": " + std::strerror(errno) +
                           "; a whole build makes it: cmake --build build/release --target programs");
}

}  // namespace lcmslam
