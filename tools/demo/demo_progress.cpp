#include "tools/demo/demo_progress.hpp"

#include <fmt/format.h>

namespace lcmslam {

std::string format_start(double elapsed, const StatusBoard& board, std::size_t processes) {
  std::string line =
      fmt::format("  {:>3.0f} s  starting: {} of {} processes", elapsed, board.size(), processes);
  for (const auto& [name, status] : board)
    if (status.state == status_t::STARTING && !status.detail.empty())
      line += "; " + name + ": " + status.detail;
  return line;
}

}  // namespace lcmslam
