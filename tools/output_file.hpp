#pragma once
// What every tool that writes a file heeds: it replaces nothing unasked, and stopped it leaves nothing.

#include <filesystem>

namespace lcmslam {

/// To be asked before any work. Throws std::runtime_error when something is at `file` already, unless it is a
/// regular file and `force` is given.
void check_output_file(const std::filesystem::path& file, bool force);

/// To be called again and again while a file is made, after install_stop_signals(). Throws std::runtime_error
/// once SIGINT or SIGTERM came: part files (files/part_file.hpp) are gone when it has passed.
void throw_when_stopped();

}  // namespace lcmslam
