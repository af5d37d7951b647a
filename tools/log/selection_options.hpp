#pragma once
// --from, --to, --channels and --without of the log tools.

#include "tools/log/log_selection.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

struct SelectionOptions {
  std::optional<double> from, to;
  std::vector<std::string> channels, without;

  void add_to(CLI::App& app) {
    const std::string time = "seconds from the log's start, or a utime (us) when above 1e9";
    app.add_option("--from", from, time);
    app.add_option("--to", to, time);
    app.add_option("--channels", channels, "only these: A,B,...")->delimiter(',');
  }

  LogSelection selection() const {
    LogSelection selection;
    if (from) selection.from = LogTime{*from};
    if (to) selection.to = LogTime{*to};
    selection.channels.insert(channels.begin(), channels.end());
    selection.without_channels.insert(without.begin(), without.end());
    selection.check();
    return selection;
  }
};

}  // namespace lcmslam
