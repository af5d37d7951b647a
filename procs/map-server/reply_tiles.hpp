#pragma once
// Answers on their way to the bus: in tiles that LCM carries, and no faster than receive buffers take them.

#include <chrono>
#include <deque>

#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/runtime/publisher.hpp>
#include "procs/map-server/question_desk.hpp"

namespace lcmslam {

class ReplyTiles {
 public:
  void add(const QuestionDesk::Answered& answered);
  /// What may go now.
  void send(Publisher& publisher);

  bool empty() const { return short_.empty() && long_.empty(); }
  bool full() const { return short_.size() + long_.size() > most_tiles; }

 private:
  static constexpr std::size_t most_tiles = 4000;  // 200 MB
  std::deque<map_reply_t> short_, long_;  // answers of one tile, which go first, and tiles of the others
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace lcmslam
