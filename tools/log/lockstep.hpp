#pragma once
// Replay in step with the mappers: a frame goes out when all of them have answered the one before. Then
// nothing is ever dropped, at whatever speed the machine has.

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "geometry/transform.hpp"

namespace lcmslam {

/// Keeps account of frames and answers. Knows no clock and no bus.
class Lockstep {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  /// A frame is given up when a channel has not answered `patience` after it was sent. A channel that
  /// misses several frames in a row is not waited for any longer, as long as others answer, until it
  /// answers again.
  Lockstep(const std::set<std::string>& channels, Duration patience);

  /// A frame went out. `utimes`: of the message and of each of its images (as calibrated): an answer may
  /// carry any of them.
  void sent(std::vector<Utime> utimes, Time now);

  /// An answer came. It explains the frame whose utimes come nearest.
  void answered(const std::string& channel, Utime utime);

  /// Whether the next frame may go: the last one is answered, or is given up now.
  bool ready(Time now);
  /// When the last frame will be given up.
  Time deadline() const { return deadline_; }
  /// The last frame is given up sooner: it may be none that can be answered.
  void shorten(Duration patience) { deadline_ = std::min(deadline_, sent_at_ + patience); }

  /// Frames of another time follow.
  void restart() { frames_.clear(); }

  struct Count {
    std::int64_t answered = 0;  ///< frames
    std::int64_t given_up = 0;
    bool silent = false;  ///< not waited for
  };
  std::int64_t frames() const { return n_frames_; }
  std::int64_t answered_by_all() const { return answered_by_all_; }
  const std::map<std::string, Count>& counts() const { return counts_; }

 private:
  struct Frame {
    std::int64_t number;
    std::vector<Utime> utimes;
  };
  struct Channel {
    std::int64_t newest = -1;  // number of the newest frame answered
    int missed = 0;            // frames in a row
  };
  std::optional<std::int64_t> explained(Utime utime) const;
  void give_up(const std::string& channel);

  Duration patience_;
  std::map<std::string, Channel> channels_;
  std::map<std::string, Count> counts_;
  std::deque<Frame> frames_;  // the newest few
  std::int64_t n_frames_ = 0, answered_by_all_ = 0;
  bool settled_ = true;  // the last frame is answered or given up
  Time sent_at_{}, deadline_{};
};

}  // namespace lcmslam
