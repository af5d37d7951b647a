#pragma once
// Plays a log on a bus: `lcmslam log play`.

#include <functional>
#include <string>

#include "tools/log/lockstep.hpp"
#include "tools/log/log_selection.hpp"
#include "tools/log/play_order.hpp"

namespace lcmslam {

struct PlaySettings {
  double speed = 1;  ///< 0: as fast as possible
  LogSelection selection;
  bool loop = false;
  bool all_channels = false;              ///< also what the graph computes
  std::set<std::string> processes;        ///< of the graph that it is played to
  std::set<std::string> answer_channels;  ///< of lockstep; none: no lockstep
  double patience = 5;                    ///< s, for the answers to a frame
  int in_flight = 1;                      ///< of lockstep: frames that may be unanswered
};

/// The bus and the time, so that tests need neither.
class PlayBus {
 public:
  using Time = std::chrono::steady_clock::time_point;
  virtual ~PlayBus() = default;
  virtual Time now() = 0;
  virtual void send(const std::string& channel, const std::vector<std::uint8_t>& bytes, Utime utime) = 0;
  /// Waits until then, or until something was heard; what is heard goes to on_answer.
  virtual void wait_until(Time time) = 0;
  virtual bool stopped() = 0;

  std::function<void(const std::string& channel, Utime utime)> on_answer;
};

struct PlayCounts {
  std::int64_t messages = 0, frames = 0;
  std::int64_t answered = 0;   ///< frames, by all channels
  std::int64_t uncovered = 0;  ///< frames for which the log has no reading that odometry is made of
  std::map<std::string, Lockstep::Count> answers;
  double log_seconds = 0, seconds = 0;
};

/// The channels that a log's player sends, given those of the log: but for what the graph computes from the
/// others and what was told to its processes; all, where nothing else is there.
std::set<std::string> channels_to_play(const std::set<std::string>& in_log, const PlaySettings& settings);

/// Throws std::runtime_error or std::invalid_argument for a log or settings that cannot be played.
PlayCounts play_log(const std::string& file, const PlaySettings& settings, PlayBus& bus);

}  // namespace lcmslam
