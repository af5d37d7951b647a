#pragma once
// The messages of a log, printed as `echo` prints those of the bus.

#include <functional>
#include <optional>
#include <string>

#include "tools/echo/echo_printer.hpp"
#include "tools/log/log_selection.hpp"

namespace lcmslam {

struct EchoLogRequest {
  std::string file;
  std::string channels;         ///< channel, or a regular expression of channels
  std::optional<LogTime> from;  ///< in log time
  double seconds = 0;           ///< after that; 0: to the end
  std::int64_t count = 0;       ///< messages at most; 0: all
};

/// Gives each message's text to `print`, until that returns false. Returns how many there were. Throws
/// std::runtime_error when the file is no log, or has no message of such channels in that time; it names the
/// channels that there are.
std::int64_t echo_log(const EchoLogRequest& request, const EchoOptions& options,
                      const std::function<bool(const std::string&)>& print);

}  // namespace lcmslam
