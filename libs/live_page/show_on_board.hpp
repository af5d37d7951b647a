#pragma once
// Items onto the board that clients are shown: what is small and urgent goes first.

#include <lcmslam/live_page/page_item.hpp>
#include <lcmslam/web/board.hpp>

namespace lcmslam {

/// Takes the place of the item of the same channel and key. One that says the same is not shown again.
void show_on(Board& board, PageItem item);

/// All items of a channel: those that are not among them go.
void show_all_on(Board& board, const std::string& channel, std::vector<PageItem> items);

}  // namespace lcmslam
