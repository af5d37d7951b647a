#pragma once
// Whether what is printed may have colours: the one place that decides.

#include <spdlog/common.h>
#include <string>

namespace lcmslam {

enum class Emphasis { good, warning, failure };

/// Only in a terminal, one that knows them (TERM is not "dumb"), and where NO_COLOR is not set
/// (no-color.org). Null: the variable is not set.
bool wants_colours(bool terminal, const char* no_color, const char* term);

/// The same for a file descriptor of this process and its environment.
bool wants_colours(int descriptor);

/// The same for a log's sink.
spdlog::color_mode log_colours(int descriptor);

/// The text, in a colour if `colours`.
std::string emphasised(const std::string& text, Emphasis emphasis, bool colours);

}  // namespace lcmslam
