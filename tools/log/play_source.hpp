#pragma once
// What of a log the player sends.

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/log/log_selection.hpp"
#include "tools/log/log_session.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/log/play_order.hpp"

namespace lcmslam {

/// The channel whose messages mappers answer; empty: there is none.
std::string frames_of(const std::set<std::string>& channels);

/// The selected messages of a log, with what the player has to know of them.
class PlaySource {
 public:
  PlaySource(const std::string& file, const LogSelection& selection, std::set<std::string> channels,
             Utime first)
      : reader_(file),
        selection_(selection),
        channels_(std::move(channels)),
        frames_(frames_of(channels_)),
        first_(first) {}

  std::optional<PlayEvent> next();

 private:
  PlayEvent describe(const LogEventView& view);
  std::vector<Utime> frame_times(const LogEventView& view, Utime utime) const;
  void calibrate(const LogEventView& view);

  MessageReader reader_;
  const LogSelection& selection_;
  std::set<std::string> channels_;
  std::string frames_;
  Utime first_;
  SessionTracker sessions_;
  bool begins_ = false;
  Utime depth_offset_ = 0;  // us
};

}  // namespace lcmslam
