#include "procs/map-server/reply_tiles.hpp"

#include <fmt/format.h>
#include <algorithm>

#include <lcmslam/messages/map_messages.hpp>
#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
void ReplyTiles::add(const QuestionDesk::Answered& answered) {
  const std::string& bytes = answered.answer.bytes;
  map_reply_t tile;
  tile.utime = answered.request.utime;
  tile.request_id = answered.request.request_id;
  tile.status = answered.error.empty() ? 0 : 1;
  tile.message = answered.error;
  tile.n_tiles =
      static_cast<std::int32_t>(std::max<std::size_t>(1, (bytes.size() + tile_bytes - 1) / tile_bytes));
  if (answered.error.empty())
    tile.content = fmt::format("{}; frame={}; map_version={}", answered.answer.content,
                               printable(answered.frame), answered.map_version);
  // A planner does not wait for the thousands of a mesh.
  std::deque<map_reply_t>& tiles = tile.n_tiles == 1 ? short_ : long_;
  for (tile.tile = 0; tile.tile < tile.n_tiles; ++tile.tile) {
    const std::size_t begin = static_cast<std::size_t>(tile.tile) * tile_bytes;
    const std::size_t end = std::min(bytes.size(), begin + tile_bytes);
    tile.data.assign(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
                     bytes.begin() + static_cast<std::ptrdiff_t>(end));
    tile.size = static_cast<std::int32_t>(tile.data.size());
    tiles.push_back(tile);
  }
}

void ReplyTiles::send(Publisher& publisher) {
  const auto pace = publisher.pace();
  while (!empty() && (pace.count() == 0 || std::chrono::steady_clock::now() >= next_)) {
    std::deque<map_reply_t>& tiles = short_.empty() ? long_ : short_;
    // Small answers need not wait: a buffer takes several of them.
    next_ = std::chrono::steady_clock::now() + pace * tiles.front().size / static_cast<int>(tile_bytes);
    publisher.publish("MAP_REPLY", tiles.front());
    tiles.pop_front();
  }
}

}  // namespace lcmslam
