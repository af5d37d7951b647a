#pragma once
#include <CLI/CLI.hpp>
#include <optional>

#include "tools/commands.hpp"

namespace lcmslam {

/// Parses a subcommand's options, --version included. Gives the exit code when there is nothing more to
/// do: 0 after --help and --version, 2 for options that are wrong.
std::optional<int> parse_command(CLI::App& app, int argc, char** argv);

/// An option or a positional argument of a command.
struct OptionDescription {
  std::vector<std::string> names;  ///< "--set", "-h"; none: positional
  std::string help;
  bool takes_value = false;
  std::string type;                ///< CLI11's: "TEXT:FILE", "KEY", ...
  std::vector<std::string> words;  ///< the only values; empty: any
};

/// What a command's parser takes. The command does not run: it ends where it would parse.
std::vector<OptionDescription> describe_command(int (*command)(int, char**));

}  // namespace lcmslam
