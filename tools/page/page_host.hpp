#pragma once
// Shows a board in browsers until it is told to stop: what `map view` and `log view` have in common.

#include <functional>

#include "procs/map-server/page/page_desk.hpp"
#include "procs/map-server/page/page_settings.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

class Board;

/// --port, --address, --token.
void add_page_options(CLI::App& app, WebSettings& settings);

/// Prints where the page is, then serves until SIGINT or SIGTERM; `turn` is called some fifty times a second.
void host_page(const WebSettings& settings, Board& board, PageDesk& desk, const std::function<void()>& turn);

}  // namespace lcmslam
