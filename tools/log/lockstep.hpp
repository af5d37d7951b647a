#pragma once
// Replay in step with the mappers: a frame goes out when all of them have answered the one before, or the
// one before that. Then nothing is ever dropped, at whatever speed the machine has.

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

/// Keeps account of frames and answers. Knows no clock and no bus.
class Lockstep {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;

  /// A frame is given up when a channel has not answered `patience` after it was sent. A channel that
  /// misses several frames in a row is not waited for any longer, as long as others answer, until it
  /// answers again. `in_flight`: frames that may be unanswered when the next one goes out, less one.
  Lockstep(const std::set<std::string>& channels, Duration patience, int in_flight = 1);

  /// A frame went out. `utimes`: of the message and of each of its images (as calibrated): an answer may
  /// carry any of them.
  void sent(std::vector<Utime> utimes, Time now);

  /// An answer came. It explains the frame whose utimes come nearest.
  void answered(const std::string& channel, Utime utime);

  /// Whether the next frame may go: fewer than `in_flight` frames wait for an answer; the oldest may be
  /// given up now.
  bool ready(Time now) { return settled(n_frames_ - in_flight_, now); }
  /// Whether no frame waits.
  bool done(Time now) { return settled(n_frames_ - 1, now); }
  /// When the oldest frame that waits will be given up.
  Time deadline() const { return waiting_.empty() ? Time::max() : waiting_.front().deadline; }
  /// The last frame is given up sooner: it may be none that can be answered.
  void shorten(Duration patience);

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
  struct Waiting {
    std::int64_t number;
    Time sent, deadline;
  };
  std::optional<std::int64_t> explained(Utime utime) const;
  bool settled(std::int64_t number, Time now);
  bool settle(const Waiting& frame, Time now);
  void give_up(const std::string& channel);

  Duration patience_;
  int in_flight_;
  std::map<std::string, Channel> channels_;
  std::map<std::string, Count> counts_;
  std::deque<Frame> frames_;     // the newest few
  std::deque<Waiting> waiting_;  // neither answered nor given up
  std::int64_t n_frames_ = 0, answered_by_all_ = 0;
};

}  // namespace lcmslam
