#include <lcmslam/runtime/terminal_colours.hpp>

#include <unistd.h>
#include <cstdlib>

namespace lcmslam {

bool wants_colours(bool terminal, const char* no_color, const char* term) {
  const bool refused = no_color != nullptr && *no_color != '\0';
  return terminal && !refused && term != nullptr && std::string(term) != "dumb";
}

bool wants_colours(int descriptor) {
  return wants_colours(isatty(descriptor) != 0, std::getenv("NO_COLOR"), std::getenv("TERM"));
}

spdlog::color_mode log_colours(int descriptor) {
  return wants_colours(descriptor) ? spdlog::color_mode::always : spdlog::color_mode::never;
}

std::string emphasised(const std::string& text, Emphasis emphasis, bool colours) {
  if (!colours) return text;
  static const char* const codes[] = {"\x1b[32m", "\x1b[33m", "\x1b[1;31m"};  // green, yellow, bold red
  return codes[static_cast<std::size_t>(emphasis)] + text + "\x1b[0m";
}

}  // namespace lcmslam
