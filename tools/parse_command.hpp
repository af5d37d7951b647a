#pragma once
#include <CLI/CLI.hpp>
#include <optional>

namespace lcmslam {

/// Parses a subcommand's options, --version included. Gives the exit code when there is nothing more to
/// do: 0 after --help and --version, 2 for options that are wrong.
std::optional<int> parse_command(CLI::App& app, int argc, char** argv);

}  // namespace lcmslam
